// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/bootstrapping.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/io/image_io.h"
#include "core/random.h"
#include "semantics/geometry/directions.h"
#include "semantics/geometry/view_loop.h"

namespace freegs::semantics {
namespace {

constexpr uint64_t kStartStream = 0x7374617274;
constexpr size_t kDecodedRows = 4096;  // Rows decoded at a time.
constexpr int64_t kStepsPerReport = 50;

// Times parts and reports their progress.
class PartClock {
 public:
  explicit PartClock(const ProgressFn& progress) : progress_(progress) {}

  // first: what was done of this part before.
  void Begin(const std::string& part, size_t total, size_t first = 0) {
    End();
    part_ = part;
    total_ = total;
    started_ = std::chrono::steady_clock::now();
    Done(first);
  }

  void Done(size_t count, const std::string& detail = "") const {
    if (!progress_) return;
    progress_({part_,
               static_cast<double>(count),
               static_cast<double>(total_),
               detail});
  }

  void End() {
    if (part_.empty()) return;
    const std::chrono::duration<double> elapsed =
        std::chrono::steady_clock::now() - started_;
    // The times of a part that comes again, such as clustering, are added up.
    const auto same =
        std::find_if(seconds_.begin(), seconds_.end(), [&](const auto& entry) {
          return entry.first == part_;
        });
    if (same != seconds_.end()) {
      same->second += elapsed.count();
    } else {
      seconds_.emplace_back(part_, elapsed.count());
    }
    part_.clear();
  }

  std::vector<std::pair<std::string, double>> Take() {
    End();
    return std::move(seconds_);
  }

 private:
  const ProgressFn& progress_;
  std::string part_;
  size_t total_ = 0;
  std::chrono::steady_clock::time_point started_;
  std::vector<std::pair<std::string, double>> seconds_;
};

LinearDecoder DecoderOfAxes(const PrincipalAxes& axes) {
  LinearDecoder decoder;
  decoder.latent_dim = axes.count;
  decoder.feature_dim = axes.dim;
  decoder.mean = axes.mean;
  decoder.basis.resize(axes.axes.size());
  for (int k = 0; k < axes.count; ++k) {
    for (int c = 0; c < axes.dim; ++c) {
      decoder.basis[static_cast<size_t>(c) * axes.count + k] =
          axes.axes[static_cast<size_t>(k) * axes.dim + c];
    }
  }
  return decoder;
}

std::string Describe(const FieldTraining& training) {
  if (training.history().empty()) return "";
  std::string text =
      "loss " + std::to_string(training.history().back().losses.pixel);
  if (!training.rounds().empty()) {
    text += ", " + std::to_string(training.rounds().back().num_instances) +
            " instances";
  }
  return text;
}

// The vectors of instances that were made of one instance or of a pair.
InstanceVectors VectorsOfJoined(std::span<const InstancePair> made_of,
                                std::span<const InstancePair> pairs,
                                const InstanceVectors& alone,
                                const InstanceVectors& together) {
  const auto dim = static_cast<size_t>(alone.dim);
  InstanceVectors result{.dim = alone.dim, .num_crops = alone.num_crops};
  for (const InstancePair& origin : made_of) {
    const auto pair = std::find(pairs.begin(), pairs.end(), origin);
    const bool is_pair = pair != pairs.end();
    const size_t row = is_pair ? pair - pairs.begin() : origin.a;
    const auto first = (is_pair ? together : alone).vectors.begin() + row * dim;
    result.vectors.insert(result.vectors.end(), first, first + dim);
  }
  return result;
}

class Bootstrapping {
 public:
  Bootstrapping(const PosedScene& scene,
                ViewPhoto photo_of,
                const BootstrappingOptions& options,
                uint64_t seed,
                BootstrapTools& tools,
                ViewWeightsStore store)
      : scene_(scene),
        photo_of_(photo_of),
        options_(options),
        seed_(seed),
        tools_(tools),
        pool_(tools.pool),
        clock_(tools.progress),
        weights_(std::move(store)) {}

  StatusOr<SemanticField> Run() {
    FREEGS_RETURN_IF_ERROR(Lift());
    FeatureDecoder decoder(DecoderOfAxes(grids_.axes));
    int64_t steps = 0;
    std::vector<ClusteringRound> rounds;
    std::vector<LossRecord> losses;
    if (options_.method == FieldMethod::kTrain) {
      FREEGS_ASSIGN_OR_RETURN(FieldState trained, Train());
      lifted_.features = std::move(trained.features);
      decoder = std::move(trained.decoder);
      steps = trained.step;
      rounds = std::move(trained.rounds);
      losses = std::move(trained.history);
    }
    FREEGS_ASSIGN_OR_RETURN(SeenInstances seen,
                            FindInstances(lifted_.features));
    if (options_.method == FieldMethod::kTrain) {
      seen.vectors = {.dim = decoder.feature_dim(),
                      .num_crops = seen.vectors.num_crops};
      FREEGS_ASSIGN_OR_RETURN(seen.vectors.vectors,
                              MeanInstanceVectors(lifted_.features,
                                                  lifted_.weights,
                                                  seen.labels.labels,
                                                  seen.labels.num_instances,
                                                  decoder,
                                                  pool_));
    }
    return SemanticField{.features = std::move(lifted_.features),
                         .num_unseen = lifted_.num_unseen,
                         .decoder = std::move(decoder),
                         .instances = std::move(seen.labels),
                         .vectors = std::move(seen.vectors),
                         .steps = steps,
                         .rounds = std::move(rounds),
                         .losses = std::move(losses),
                         .seconds = clock_.Take()};
  }

 private:
  // Features of photographs, and their averages on Gaussians.
  Status Lift() {
    clock_.Begin("features of photographs", scene_.views.size());
    FREEGS_ASSIGN_OR_RETURN(
        grids_,
        ComputeFeatureGrids(scene_.views.size(),
                            photo_of_,
                            tools_.encoder,
                            tools_.cache,
                            options_.features,
                            pool_,
                            tools_.cancellation,
                            [&](size_t count) { clock_.Done(count); }));
    // Two rounds: photographs are read, then their features are lifted.
    const size_t num_views = scene_.views.size();
    clock_.Begin("lifting features", 2 * num_views);
    guides_.resize(num_views);
    FREEGS_RETURN_IF_ERROR(ForEachView(
        "lifting features",
        num_views,
        pool_,
        tools_.cancellation,
        [&](size_t count) { clock_.Done(count); },
        [&](size_t view) -> Status {
          FREEGS_ASSIGN_OR_RETURN(const ImageU8 photo, photo_of_(view));
          const Pinhole& camera = weights_.camera(view);
          guides_[view] = ToFloat(Resize(photo, camera.width, camera.height));
          return Status();
        }));
    const auto features_of = [&](size_t view) -> StatusOr<ImageF> {
      if (IsCancelled(tools_.cancellation)) {
        return InterruptedError("lifting features was interrupted");
      }
      clock_.Done(num_views + view);
      return UpsampleView(
          grids_, view, guides_[view], options_.upsampling, pool_);
    };
    FREEGS_ASSIGN_OR_RETURN(lifted_,
                            LiftFeatures(weights_, features_of, pool_));
    return Status();
  }

  StatusOr<InstanceLabels> Cluster(std::span<const float> features) {
    clock_.Begin("clustering", 0);
    // Photographs are looked at before the first clustering; the others only
    // bring new semantics.
    if (!clusterer_) {
      FREEGS_ASSIGN_OR_RETURN(
          clusterer_,
          InstanceClusterer::Create(scene_.model,
                                    scene_.all_views,
                                    {.views = scene_.views,
                                     .photo_of = photo_of_,
                                     .render = scene_.render},
                                    options_.clustering,
                                    pool_,
                                    tools_.cancellation));
    }
    return clusterer_->Cluster(
        {features, grids_.axes.count}, pool_, tools_.cancellation);
  }

  // Instances, and the vectors of what the photographs show of them.
  struct SeenInstances {
    InstanceLabels labels;
    InstanceVectors vectors;
  };

  // Clusters the Gaussians with these features, looks at the instances, and
  // makes one of those that are recognised as one.
  StatusOr<SeenInstances> FindInstances(std::span<const float> features) {
    SeenInstances found;
    FREEGS_ASSIGN_OR_RETURN(found.labels, Cluster(features));
    clock_.Begin("features of instances", scene_.views.size());
    const auto done = [&](size_t count) { clock_.Done(count); };
    InstanceEncoder encoder(
        {scene_.model, scene_.views, scene_.render, photo_of_},
        tools_.encoder,
        options_.instances,
        pool_,
        tools_.cancellation);
    FREEGS_RETURN_IF_ERROR(
        encoder.Look(found.labels.labels, found.labels.num_instances));
    FREEGS_ASSIGN_OR_RETURN(
        found.vectors,
        encoder.Encode(EachAlone(found.labels.num_instances), done));
    if (!tools_.things.have_say()) return found;

    const std::vector<InstancePair> pairs =
        clusterer_->PairsThatMeet(found.labels);
    if (pairs.empty()) return found;
    std::vector<std::vector<int32_t>> groups;
    for (const auto& [a, b] : pairs) groups.push_back({a, b});
    FREEGS_ASSIGN_OR_RETURN(const InstanceVectors together,
                            encoder.Encode(groups, done));
    found.vectors.num_crops += together.num_crops;
    std::vector<WholePair> wholes =
        FindNamedWholes(pairs, found.vectors, together, tools_.things);
    if (wholes.empty()) return found;
    JoinedInstances joined = clusterer_->Join(found.labels, std::move(wholes));
    found.vectors =
        VectorsOfJoined(joined.made_of, pairs, found.vectors, together);
    found.labels = std::move(joined.labels);
    return found;
  }

  // Takes the state to resume from, or the lifted vectors. Neither is needed
  // any more, and each is as large as what is trained.
  FieldState FirstState() {
    std::vector<float> vectors = std::move(lifted_.features);
    if (tools_.resume_from) return *std::move(tools_.resume_from);
    if (options_.random_start) {
      const auto dim = static_cast<size_t>(grids_.axes.count);
      for (size_t i = 0; i < vectors.size(); ++i) {
        if (!lifted_.seen(i / dim)) continue;  // The vector stays zero.
        vectors[i] = static_cast<float>(RandomNormal(seed_, kStartStream, i));
      }
    }
    return FieldTraining::InitialState(std::move(vectors),
                                       grids_.axes.count,
                                       grids_.axes.dim,
                                       options_.training,
                                       seed_);
  }

  StatusOr<FieldState> Train() {
    FREEGS_ASSIGN_OR_RETURN(FieldTraining training,
                            FieldTraining::Create({scene_.model,
                                                   scene_.views,
                                                   scene_.render,
                                                   grids_,
                                                   guides_,
                                                   options_.upsampling,
                                                   weights_},
                                                  options_.training,
                                                  seed_,
                                                  FirstState(),
                                                  pool_));
    BeginTraining(training);
    while (!training.finished()) {
      if (IsCancelled(tools_.cancellation)) {
        if (tools_.save) FREEGS_RETURN_IF_ERROR(tools_.save(training, true));
        return InterruptedError(
            "training of the semantic field was interrupted at step " +
            std::to_string(training.step()));
      }
      if (training.clusters_next()) {
        const Status taught = ClusterAndTeach(training);
        // If clustering was cancelled, the next turn saves and stops.
        if (!taught.ok() && !IsCancelled(tools_.cancellation)) return taught;
        BeginTraining(training);
        continue;
      }
      FREEGS_RETURN_IF_ERROR(training.Step(pool_));
      if (training.step() % kStepsPerReport == 0) {
        clock_.Done(training.step(), Describe(training));
        if (tools_.save) FREEGS_RETURN_IF_ERROR(tools_.save(training, false));
      }
    }
    // Whoever cancels what follows need not train again.
    if (tools_.save) FREEGS_RETURN_IF_ERROR(tools_.save(training, true));
    return training.state();
  }

  void BeginTraining(const FieldTraining& training) {
    clock_.Begin("training", options_.training.iterations, training.step());
  }

  Status ClusterAndTeach(FieldTraining& training) {
    FREEGS_ASSIGN_OR_RETURN(SeenInstances seen,
                            FindInstances(training.features()));
    return training.Teach({seen.labels.num_instances,
                           std::move(seen.labels.labels),
                           std::move(seen.vectors.vectors)},
                          pool_);
  }

  const PosedScene& scene_;
  const ViewPhoto photo_of_;
  const BootstrappingOptions& options_;
  const uint64_t seed_;
  BootstrapTools& tools_;
  ThreadPool& pool_;
  PartClock clock_;
  ViewWeightsStore weights_;
  FeatureGrids grids_;
  std::vector<ImageF> guides_;  // Photographs at the weights' size.
  LiftedFeatures lifted_;
  std::optional<InstanceClusterer> clusterer_;
};

}  // namespace

Status BootstrappingOptions::Check() const {
  FREEGS_RETURN_IF_ERROR(features.Check());
  FREEGS_RETURN_IF_ERROR(upsampling.Check());
  FREEGS_RETURN_IF_ERROR(weights.Check());
  FREEGS_RETURN_IF_ERROR(clustering.Check());
  FREEGS_RETURN_IF_ERROR(instances.Check());
  FREEGS_RETURN_IF_ERROR(training.Check());
  return Status();
}

StatusOr<std::vector<float>> MeanInstanceVectors(
    std::span<const float> features,
    std::span<const double> weights,
    std::span<const int32_t> labels,
    int num_instances,
    const FeatureDecoder& decoder,
    ThreadPool& pool) {
  const auto dim = static_cast<size_t>(decoder.latent_dim());
  const auto channels = static_cast<size_t>(decoder.feature_dim());
  std::vector<double> sums(num_instances * channels, 0.0);
  std::vector<float> decoded;
  for (size_t first = 0; first < labels.size(); first += kDecodedRows) {
    const size_t count = std::min(kDecodedRows, labels.size() - first);
    decoded.resize(count * channels);
    FREEGS_RETURN_IF_ERROR(decoder.Decode(
        features.subspan(first * dim, count * dim), pool, decoded));
    for (size_t k = 0; k < count; ++k) {
      const int32_t label = labels[first + k];
      if (label < 0 || !(weights[first + k] > 0)) continue;
      AddDirection(std::span(decoded).subspan(k * channels, channels),
                   weights[first + k],
                   std::span(sums).subspan(label * channels, channels));
    }
  }
  std::vector<float> means(sums.size());
  for (size_t row = 0; row < sums.size(); row += channels) {
    WriteDirection(std::span(sums).subspan(row, channels),
                   std::span(means).subspan(row, channels));
  }
  return means;
}

StatusOr<SemanticField> BootstrapSemanticField(
    const PosedScene& scene,
    ViewPhoto photo_of,
    const BootstrappingOptions& options,
    uint64_t seed,
    BootstrapTools tools) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  FREEGS_ASSIGN_OR_RETURN(
      ViewWeightsStore weights,
      ViewWeightsStore::Create(
          scene.model, scene.views, scene.render, options.weights));
  return Bootstrapping(
             scene, photo_of, options, seed, tools, std::move(weights))
      .Run();
}

}  // namespace freegs::semantics
