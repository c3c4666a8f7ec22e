// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bootstrap/bootstrap_stage.h"

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "pipeline/resource_usage.h"
#include "pipeline/workspace.h"
#include "semantics/field/bootstrapping.h"
#include "semantics/field/field_checkpoint.h"
#include "semantics/field/idsf.h"
#include "semantics/instances/hierarchy.h"
#include "semantics/instances/instances.h"
#include "semantics/instances/instances_json.h"
#include "semantics/losses/decoder_file.h"
#include "semantics/queries/instance_features.h"
#include "semantics/queries/instance_words.h"
#include "stages/bootstrap/bootstrap_forecast.h"
#include "stages/bootstrap/bootstrap_metrics.h"
#include "stages/bootstrap/instance_doubts.h"
#include "stages/bootstrap/seen_photo.h"
#include "stages/scene/clip_input.h"
#include "stages/scene/instance_maps.h"
#include "stages/scene/scene_instances.h"
#include "stages/scene/training_scene.h"
#include "stages/scene/working_frame.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

struct NamedField {
  semantics::SemanticField field;
  semantics::InstanceNames names;
};

class BootstrapStage : public pipeline::Stage {
 public:
  BootstrapStage(const BootstrapStageOptions& options, uint64_t seed)
      : options_(options), seed_(seed) {}

  std::string_view name() const override { return "bootstrap"; }
  int version() const override { return 22; }

  std::vector<fs::path> Inputs(
      const pipeline::StageContext& context) const override {
    std::vector<fs::path> inputs = {"reconstruct/point_cloud.ply",
                                    "undistort/sparse",
                                    "undistort/images",
                                    "ingest/images.json"};
    if (!TrainingMaskFolder(context.workspace).empty()) {
      inputs.emplace_back("undistort/masks");
      // For ReadSeenPhoto; there is no such file where no exposure was learnt.
      inputs.emplace_back("reconstruct/exposure.json");
    }
    if (with_semantics()) {
      // model.json holds the hashes of the model's other files. When the model
      // is missing, Run reports that.
      const StatusOr<fs::path> model = ClipModelFolder(options_.model);
      if (model.ok()) inputs.push_back(*model / "model.json");
    }
    return inputs;
  }

  std::vector<std::string> Disposable() const override {
    return {"checkpoints", "features"};
  }

  pipeline::StageNeed Foretell(const pipeline::StageContext& context,
                               bool /*done*/,
                               pipeline::SceneOutlook* scene) const override {
    return BootstrapNeed(
        options_, ModelBytes(), context.pool->num_threads(), *scene);
  }

  Status Run(pipeline::StageContext& context) override {
    const pipeline::ResourceMeter meter;
    FREEGS_ASSIGN_OR_RETURN(semantics::BootstrappingOptions method,
                            MakeBootstrappingOptions(options_));
    if (!with_semantics() && !options_.model.empty()) {
      context.log(
          pipeline::LogLevel::kWarning,
          "bootstrap.model is not used, because bootstrap.mode geometry "
          "gives no semantics; use it with --bootstrap.mode lift");
    }
    FREEGS_ASSIGN_OR_RETURN(const WorkspaceScene scene,
                            ReadWorkspaceScene(context.workspace));
    std::vector<View> views = scene.train;
    views.insert(views.end(), scene.holdout.begin(), scene.holdout.end());
    FREEGS_RETURN_IF_ERROR(
        CheckVisible(scene.model, views, scene.render, *context.pool));
    FREEGS_ASSIGN_OR_RETURN(
        const NamedField named,
        MakeField(scene, views, std::move(method), context));
    const semantics::SemanticField& field = named.field;
    const semantics::InstanceLabels& labels = field.instances;
    if (labels.num_instances == 0) {
      return UnusableResultError(
          "no instance was found among " + std::to_string(scene.model.size()) +
          " Gaussians; try a better reconstruction or, with "
          "bootstrap.clustering union, a smaller bootstrap.min_cluster_size or "
          "bootstrap.min_samples");
    }
    for (const std::string& doubt :
         DoubtsAbout(labels, options_.clustering == "union")) {
      context.log(pipeline::LogLevel::kWarning, doubt);
    }
    std::vector<semantics::Instance> instances = semantics::BuildInstances(
        scene.model,
        labels.labels,
        labels.num_instances,
        labels.scores,
        labels.is_plane,
        semantics::EstimateVertical(views, labels.planes),
        {},
        *context.pool);
    for (semantics::Instance& instance : instances) {
      instance = InWorld(scene.frame, std::move(instance));
    }
    for (size_t i = 0; i < named.names.words.size(); ++i) {
      instances[i].words = named.names.words[i];
    }
    FREEGS_RETURN_IF_ERROR(semantics::WriteIdsf(
        context.output / "idsf.bin",
        {.feature_dim = with_semantics() ? field.decoder.latent_dim() : 0,
         .features = field.features,
         .instances = labels.labels}));
    FREEGS_RETURN_IF_ERROR(semantics::WriteInstances(
        context.output / "instances.json", instances));
    if (labels.hierarchy) {
      FREEGS_RETURN_IF_ERROR(semantics::WriteHierarchy(
          context.output / "hierarchy.json", *labels.hierarchy));
    }
    FREEGS_RETURN_IF_ERROR(WriteInstanceMaps(
        options_.num_previews, scene, views, labels.labels, context));
    return WriteBootstrapMetrics(options_,
                                 scene.model.size(),
                                 field,
                                 instances,
                                 named.names.num_withheld,
                                 meter,
                                 context);
  }

 private:
  bool with_semantics() const { return options_.mode != "geometry"; }

  // The networks of the CLIP model. A model that is missing has none.
  int64_t ModelBytes() const {
    const StatusOr<fs::path> model = ClipModelFolder(options_.model);
    int64_t bytes = 0;
    std::error_code error;
    if (!model.ok()) return bytes;
    for (fs::directory_iterator file(*model, error), end; file != end;
         file.increment(error)) {
      if (file->path().extension() != ".onnx") continue;
      std::error_code unreadable;
      const uintmax_t size = file->file_size(unreadable);
      if (!unreadable) bytes += static_cast<int64_t>(size);
    }
    return bytes;
  }

  StatusOr<NamedField> MakeField(const WorkspaceScene& scene,
                                 const std::vector<View>& views,
                                 semantics::BootstrappingOptions method,
                                 pipeline::StageContext& context) const {
    const std::vector<View> teachers = Teachers(options_, scene.train);
    const auto photo_of = [&](size_t view) {
      return ReadSeenPhoto(context.workspace, scene, teachers[view]);
    };
    if (!with_semantics()) {
      context.progress({"clustering", 0, 1, ""});
      semantics::SemanticField field;
      FREEGS_ASSIGN_OR_RETURN(
          semantics::InstanceClusterer clusterer,
          semantics::InstanceClusterer::Create(
              scene.model,
              views,
              {.views = teachers, .photo_of = photo_of, .render = scene.render},
              method.clustering,
              *context.pool,
              context.cancellation));
      FREEGS_ASSIGN_OR_RETURN(
          field.instances,
          clusterer.Cluster({}, *context.pool, context.cancellation));
      return NamedField{std::move(field), {}};
    }
    FREEGS_ASSIGN_OR_RETURN(const auto encoder, OpenClipModel(options_.model));
    method.weights.scratch_folder = context.output;
    const semantics::FeatureCache cache(context.output / "features");
    const fs::path checkpoint = context.output / "checkpoints" / "field.ckpt";
    FREEGS_ASSIGN_OR_RETURN(
        semantics::Vocabulary vocabulary,
        semantics::Vocabulary::Create(encoder->info().vocabulary, *encoder));
    const semantics::KnownThings things{std::move(vocabulary),
                                        encoder->info().min_word_confidence};
    semantics::BootstrapTools tools{.encoder = *encoder,
                                    .cache = cache,
                                    .pool = *context.pool,
                                    .cancellation = context.cancellation,
                                    .progress = context.progress,
                                    .resume_from = std::nullopt,
                                    .save = nullptr,
                                    .things = things};
    if (method.method == semantics::FieldMethod::kTrain) {
      tools.resume_from = CheckpointOf(checkpoint, context);
      tools.save = SaverTo(checkpoint, context);
    }
    FREEGS_ASSIGN_OR_RETURN(semantics::SemanticField field,
                            semantics::BootstrapSemanticField(
                                {scene.model, teachers, views, scene.render},
                                photo_of,
                                method,
                                seed_,
                                std::move(tools)));
    FREEGS_RETURN_IF_ERROR(semantics::WriteDecoder(
        context.output / "decoder.bin", {field.decoder, std::nullopt}));
    FREEGS_RETURN_IF_ERROR(semantics::WriteInstanceFeatures(
        context.output / "instance_features.json",
        {.dim = field.vectors.dim,
         // A model in the workspace is found again when that is moved.
         .model =
             options_.model.empty()
                 ? encoder->info().name
                 : pipeline::DisplayPath(context.workspace, options_.model),
         .model_hash = encoder->model_hash(),
         .features = field.vectors.vectors}));
    semantics::InstanceNames names =
        semantics::NameInstances(field.vectors.vectors,
                                 field.vectors.dim,
                                 things.vocabulary,
                                 things.min_confidence);
    return NamedField{std::move(field), std::move(names)};
  }

  // The checkpoint of an interrupted run. A damaged one only costs time: the
  // training starts anew.
  static std::optional<semantics::FieldState> CheckpointOf(
      const fs::path& path, const pipeline::StageContext& context) {
    std::error_code error;
    if (!context.resuming || !fs::exists(path, error)) return std::nullopt;
    StatusOr<semantics::FieldState> state = semantics::ReadFieldState(path);
    if (!state.ok()) {
      context.log(pipeline::LogLevel::kWarning, state.status().message());
      return std::nullopt;
    }
    context.log(pipeline::LogLevel::kInfo,
                "going on from step " + std::to_string(state->step));
    return *std::move(state);
  }

  static std::function<Status(const semantics::FieldTraining&, bool)> SaverTo(
      const fs::path& path, const pipeline::StageContext& context) {
    using Clock = std::chrono::steady_clock;
    return [path,
            interval = std::chrono::duration<double>(
                context.checkpoint_interval_seconds),
            last = Clock::now()](const semantics::FieldTraining& training,
                                 bool stopping) mutable -> Status {
      if (!stopping && Clock::now() - last < interval) return Status();
      FREEGS_RETURN_IF_ERROR(CreateFolders(path.parent_path()));
      FREEGS_RETURN_IF_ERROR(
          semantics::WriteFieldState(path, training.state()));
      last = Clock::now();
      return Status();
    };
  }

  BootstrapStageOptions options_;
  uint64_t seed_;
};

}  // namespace

std::unique_ptr<pipeline::Stage> MakeBootstrapStage(
    const BootstrapStageOptions& options, uint64_t seed) {
  return std::make_unique<BootstrapStage>(options, seed);
}

}  // namespace freegs::stages
