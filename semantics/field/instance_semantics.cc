// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/instance_semantics.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/io/image_io.h"
#include "semantics/crf/dense_crf.h"
#include "semantics/crf/unary_energies.h"
#include "semantics/field/instance_crops.h"
#include "semantics/geometry/directions.h"

namespace freegs::semantics {
namespace {

// Labels of a view's pixels; -1 for none.
using LabelImage = Image<int32_t>;

// Longest side in pixels at which instances are looked for.
constexpr int kMaxSide = 480;
// Share of a view's pixels below which an instance is too small to be
// recognised there. FreeGS: 300 pixels, whatever the resolution.
constexpr double kMinShare = 0.0005;
// Width of the surroundings that are cut out on each side of an instance, in
// units of its longer side.
constexpr double kMargin = 0.1;
// How sure the rendered labels are before refinement.
constexpr double kLabelConfidence = 0.7;

// Refines labels by a conditional random field that trusts them with
// probability kLabelConfidence. Having no label counts as a label.
StatusOr<LabelImage> RefineLabels(const LabelImage& labels,
                                  const ImageU8& photo,
                                  ThreadPool& pool) {
  std::vector<int32_t> present(labels.data(), labels.data() + labels.size());
  std::sort(present.begin(), present.end());
  present.erase(std::unique(present.begin(), present.end()), present.end());
  if (present.size() < 2) return labels;
  ImageU16 numbers(labels.width(), labels.height(), 1);
  for (size_t i = 0; i < labels.size(); ++i) {
    numbers.data()[i] = static_cast<uint16_t>(
        std::lower_bound(present.begin(), present.end(), labels.data()[i]) -
        present.begin());
  }
  FREEGS_ASSIGN_OR_RETURN(
      const ImageF unary,
      UnaryFromLabels(
          numbers, static_cast<int>(present.size()), kLabelConfidence));
  FREEGS_ASSIGN_OR_RETURN(const DenseCrf crf,
                          DenseCrf::Build(ToFloat(photo), {}, pool));
  FREEGS_ASSIGN_OR_RETURN(const DenseCrfResult result, crf.Infer(unary, pool));
  LabelImage refined(labels.width(), labels.height(), 1);
  for (size_t i = 0; i < refined.size(); ++i) {
    refined.data()[i] = present[result.labels.data()[i]];
  }
  return refined;
}

// The instances to cut out of each view.
std::vector<std::vector<int32_t>> InstancesByView(
    std::vector<std::vector<LabelSight>> sights,
    size_t num_views,
    size_t views_per_instance) {
  std::vector<std::vector<int32_t>> result(num_views);
  for (size_t label = 0; label < sights.size(); ++label) {
    for (const LabelSight& sight :
         BestSights(std::move(sights[label]), views_per_instance)) {
      result[sight.view].push_back(static_cast<int32_t>(label));
    }
  }
  return result;
}

class Encoding {
 public:
  Encoding(ClipEncoder& encoder, int num_instances) : encoder_(encoder) {
    result_.dim = encoder.embedding_dim();
    sums_.assign(static_cast<size_t>(num_instances) * result_.dim, 0.0);
  }

  // Does nothing if refinement has removed the label from the view.
  Status Add(const ImageU8& photo, const LabelImage& labels, int32_t label) {
    const std::optional<InstanceCrop> crop =
        CropInstance(photo, labels, label, kMargin);
    if (!crop) return Status();
    for (const ImageU8* image : {&crop->in_place, &crop->alone}) {
      FREEGS_ASSIGN_OR_RETURN(const std::vector<float> vector,
                              encoder_.EncodeImage(*image));
      AddDirection(vector, 1, Sum(label));
    }
    ++result_.num_crops;
    return Status();
  }

  InstanceVectors Take() {
    result_.vectors.resize(sums_.size());
    const size_t dim = result_.dim;
    for (size_t first = 0; first < sums_.size(); first += dim) {
      WriteDirection(std::span(sums_).subspan(first, dim),
                     std::span(result_.vectors).subspan(first, dim));
    }
    return std::move(result_);
  }

 private:
  std::span<double> Sum(int32_t label) {
    const auto dim = static_cast<size_t>(result_.dim);
    return std::span(sums_).subspan(label * dim, dim);
  }

  ClipEncoder& encoder_;
  std::vector<double> sums_;  // Of each instance's directions.
  InstanceVectors result_;
};

}  // namespace

Status InstanceSemanticsOptions::Check() const {
  if (views_per_instance < 1) {
    return InvalidArgumentError("views_per_instance must be positive");
  }
  return Status();
}

StatusOr<InstanceVectors> EncodeInstances(
    const splat::GaussianModel& model,
    std::span<const View> views,
    const splat::RenderOptions& render,
    std::span<const int32_t> labels,
    int num_instances,
    ViewPhoto photo_of,
    ClipEncoder& encoder,
    const InstanceSemanticsOptions& options,
    ThreadPool& pool,
    const CancellationToken* cancellation,
    ViewsDone done) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  std::vector<LabelImage> maps;
  std::vector<std::vector<LabelSight>> sights(num_instances);
  for (size_t view = 0; view < views.size(); ++view) {
    const Pinhole camera = views[view].camera.LimitedTo(kMaxSide);
    maps.push_back(splat::RenderLabels(
        model, camera, views[view].cam_from_world, render, pool, labels));
    const auto min_pixels = static_cast<int64_t>(
        kMinShare * static_cast<double>(maps.back().num_pixels()));
    CollectSights(view, maps.back(), min_pixels, sights);
  }
  const std::vector<std::vector<int32_t>> wanted = InstancesByView(
      std::move(sights), views.size(), options.views_per_instance);

  Encoding encoding(encoder, num_instances);
  for (size_t view = 0; view < views.size(); ++view) {
    if (cancellation != nullptr && cancellation->cancelled()) {
      return InterruptedError("encoding instances was interrupted");
    }
    if (!wanted[view].empty()) {
      FREEGS_ASSIGN_OR_RETURN(ImageU8 photo, photo_of(view));
      const LabelImage& map = maps[view];
      if (photo.width() != map.width() || photo.height() != map.height()) {
        photo = Resize(photo, map.width(), map.height());
      }
      LabelImage refined = map;
      if (options.refine) {
        FREEGS_ASSIGN_OR_RETURN(refined, RefineLabels(map, photo, pool));
      }
      for (const int32_t label : wanted[view]) {
        FREEGS_RETURN_IF_ERROR(encoding.Add(photo, refined, label));
      }
    }
    done(view + 1);
  }
  return encoding.Take();
}

}  // namespace freegs::semantics
