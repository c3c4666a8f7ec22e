// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/bootstrapping.h"

#include <chrono>
#include <cmath>

#include "core/image_io.h"

namespace freegs::semantics {
namespace {

// Times steps and reports their progress.
class StepClock {
 public:
  StepClock(const ProgressFn& progress, SemanticField* field)
      : progress_(progress), field_(field) {}

  void Begin(const std::string& step, size_t total) {
    End();
    step_ = step;
    total_ = total;
    started_ = std::chrono::steady_clock::now();
    Done(0);
  }

  void Done(size_t count) const {
    if (progress_) {
      progress_(
          {step_, static_cast<double>(count), static_cast<double>(total_), ""});
    }
  }

  void End() {
    if (step_.empty()) return;
    const std::chrono::duration<double> elapsed =
        std::chrono::steady_clock::now() - started_;
    field_->seconds.emplace_back(step_, elapsed.count());
    step_.clear();
  }

 private:
  const ProgressFn& progress_;
  SemanticField* field_;
  std::string step_;
  size_t total_ = 0;
  std::chrono::steady_clock::time_point started_;
};

// v / |v|, or nothing of a vector of no length, times weight onto sum.
void AddDirection(std::span<const float> v,
                  double weight,
                  std::span<double> sum) {
  double square = 0;
  for (const float x : v) square += double{x} * x;
  if (!(square > 0)) return;
  const double scale = weight / std::sqrt(square);
  for (size_t c = 0; c < v.size(); ++c) sum[c] += scale * v[c];
}

// Rows of length 1, or zero: `share` of the directions of a, the rest of b's.
std::vector<float> MixDirections(const std::vector<float>& a,
                                 const std::vector<float>& b,
                                 int dim,
                                 double share) {
  std::vector<float> mixed(a.size(), 0.0f);
  std::vector<double> sum(dim);
  for (size_t row = 0; row < a.size(); row += dim) {
    std::fill(sum.begin(), sum.end(), 0.0);
    AddDirection(std::span(a).subspan(row, dim), share, sum);
    AddDirection(std::span(b).subspan(row, dim), 1 - share, sum);
    double square = 0;
    for (const double x : sum) square += x * x;
    if (!(square > 0)) continue;
    const double scale = 1 / std::sqrt(square);
    for (int c = 0; c < dim; ++c) {
      mixed[row + c] = static_cast<float>(scale * sum[c]);
    }
  }
  return mixed;
}

}  // namespace

Status BootstrappingOptions::Check() const {
  FREEGS_RETURN_IF_ERROR(features.Check());
  FREEGS_RETURN_IF_ERROR(upsampling.Check());
  FREEGS_RETURN_IF_ERROR(weights.Check());
  FREEGS_RETURN_IF_ERROR(clustering.Check());
  FREEGS_RETURN_IF_ERROR(instances.Check());
  if (!(instance_share >= 0 && instance_share <= 1)) {
    return InvalidArgumentError("instance_share must lie in [0, 1]");
  }
  return Status();
}

std::vector<float> MeanInstanceVectors(std::span<const float> vectors,
                                       std::span<const double> weights,
                                       std::span<const int32_t> labels,
                                       int num_instances,
                                       const PrincipalAxes& axes,
                                       ThreadPool& pool) {
  const auto dim = static_cast<size_t>(axes.count);
  std::vector<double> sums(num_instances * dim, 0.0);
  for (size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] < 0) continue;
    AddDirection(vectors.subspan(i * dim, dim),
                 weights[i],
                 std::span(sums).subspan(labels[i] * dim, dim));
  }
  std::vector<float> means(sums.size());
  for (size_t k = 0; k < sums.size(); ++k) {
    means[k] = static_cast<float>(sums[k]);
  }
  std::vector<float> expanded = ExpandFromAxes(axes, means, pool);
  return MixDirections(expanded, expanded, axes.dim, 1);
}

StatusOr<SemanticField> LiftSemanticField(const PosedScene& scene,
                                          ViewPhoto photo_of,
                                          const BootstrappingOptions& options,
                                          uint64_t seed,
                                          const BootstrapTools& tools) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  SemanticField field;
  StepClock clock(tools.progress, &field);
  const auto done = [&](size_t count) { clock.Done(count); };

  clock.Begin("features of photographs", scene.views.size());
  FREEGS_ASSIGN_OR_RETURN(FeatureGrids features,
                          ComputeFeatureGrids(scene.views.size(),
                                              photo_of,
                                              tools.encoder,
                                              tools.cache,
                                              options.features,
                                              tools.pool,
                                              tools.cancellation,
                                              done));

  clock.Begin("lifting features", scene.views.size());
  FREEGS_ASSIGN_OR_RETURN(
      ViewWeightsStore store,
      ViewWeightsStore::Create(
          scene.model, scene.views, scene.render, options.weights));
  const auto features_of = [&](size_t view) -> StatusOr<ImageF> {
    if (tools.cancellation != nullptr && tools.cancellation->cancelled()) {
      return InterruptedError("lifting features was interrupted");
    }
    clock.Done(view);
    FREEGS_ASSIGN_OR_RETURN(const ImageU8 photo, photo_of(view));
    const Pinhole& camera = store.camera(view);
    return JointBilateralUpsample(
        features.grids[view],
        ToFloat(Resize(photo, camera.width, camera.height)),
        options.upsampling,
        tools.pool);
  };
  FREEGS_ASSIGN_OR_RETURN(field.lifted,
                          LiftFeatures(store, features_of, tools.pool));
  field.axes = std::move(features.axes);

  clock.Begin("clustering", 0);
  FREEGS_ASSIGN_OR_RETURN(
      field.instances,
      ClusterInstances(scene.model,
                       {field.lifted.features, field.lifted.channels},
                       scene.all_views,
                       options.clustering,
                       seed,
                       tools.pool,
                       tools.cancellation));

  clock.Begin("features of instances", scene.views.size());
  FREEGS_ASSIGN_OR_RETURN(field.vectors,
                          EncodeInstances(scene.model,
                                          scene.views,
                                          scene.render,
                                          field.instances.labels,
                                          field.instances.num_instances,
                                          photo_of,
                                          tools.encoder,
                                          options.instances,
                                          tools.pool,
                                          tools.cancellation,
                                          done));
  field.vectors.vectors =
      MixDirections(field.vectors.vectors,
                    MeanInstanceVectors(field.lifted.features,
                                        field.lifted.weights,
                                        field.instances.labels,
                                        field.instances.num_instances,
                                        field.axes,
                                        tools.pool),
                    field.axes.dim,
                    options.instance_share);
  clock.End();
  return field;
}

}  // namespace freegs::semantics
