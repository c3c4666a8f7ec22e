// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bootstrap_stage.h"

#include <algorithm>
#include <system_error>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/files.h"
#include "core/image_io.h"
#include "pipeline/resource_usage.h"
#include "semantics/idsf.h"
#include "semantics/instances.h"
#include "semantics/instances_json.h"
#include "splat/renderer.h"
#include "stages/scene_instances.h"
#include "stages/workspace_scene.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

class BootstrapStage : public pipeline::Stage {
 public:
  BootstrapStage(const BootstrapStageOptions& options, uint64_t seed)
      : options_(options), seed_(seed) {
    options_.clustering.hdbscan.method =
        options.method == "leaf" ? semantics::ClusterSelection::kLeaf
                                 : semantics::ClusterSelection::kExcessOfMass;
  }

  std::string_view name() const override { return "bootstrap"; }

  std::vector<fs::path> Inputs(const pipeline::StageContext&) const override {
    return {"reconstruct/point_cloud.ply",
            "undistort/sparse",
            "undistort/images",
            "ingest/images.json"};
  }

  Status Run(pipeline::StageContext& context) override {
    const pipeline::ResourceMeter meter;
    FREEGS_ASSIGN_OR_RETURN(const WorkspaceScene scene,
                            ReadWorkspaceScene(context.workspace));
    std::vector<View> views = scene.train;
    views.insert(views.end(), scene.holdout.begin(), scene.holdout.end());

    context.progress({"clustering", 0, 1, ""});
    FREEGS_ASSIGN_OR_RETURN(const semantics::InstanceLabels labels,
                            semantics::ClusterInstances(scene.model,
                                                        views,
                                                        options_.clustering,
                                                        seed_,
                                                        *context.pool,
                                                        context.cancellation));
    if (labels.num_instances == 0) {
      return UnusableResultError(
          "bootstrap: no instance was found among " +
          std::to_string(scene.model.size()) +
          " Gaussians; try a smaller bootstrap.min_cluster_size or "
          "bootstrap.min_samples, or a better reconstruction");
    }
    const std::vector<semantics::Instance> instances =
        semantics::BuildInstances(
            scene.model,
            labels.labels,
            labels.num_instances,
            labels.scores,
            labels.is_plane,
            semantics::EstimateVertical(views, labels.planes),
            {},
            *context.pool);
    FREEGS_RETURN_IF_ERROR(semantics::WriteIdsf(
        context.output / "idsf.bin",
        {.feature_dim = 0, .features = {}, .instances = labels.labels}));
    FREEGS_RETURN_IF_ERROR(semantics::WriteInstances(
        context.output / "instances.json", instances));
    FREEGS_RETURN_IF_ERROR(RenderMaps(scene, views, labels.labels, context));
    return WriteMetrics(scene, labels, instances, meter, context);
  }

 private:
  // Maps are written atomically and depend on inputs and options only: those an
  // interrupted run left are kept.
  Status RenderMaps(const WorkspaceScene& scene,
                    const std::vector<View>& views,
                    const std::vector<int32_t>& labels,
                    pipeline::StageContext& context) const {
    FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                            OutputNames(views, ".png"));
    const int64_t count = static_cast<int64_t>(views.size());
    const int64_t num_previews =
        std::min<int64_t>(options_.num_previews, count);
    for (int64_t i = 0; i < count; ++i) {
      if (context.cancellation->cancelled()) {
        return InterruptedError(
            "bootstrap: stopped while drawing instance maps; those drawn are "
            "kept");
      }
      context.progress({"instance maps",
                        static_cast<double>(i),
                        static_cast<double>(count),
                        ""});
      const fs::path map_path = context.output / "instances" / names[i];
      const fs::path preview_path = context.output / "preview" / names[i];
      // The first view of each of num_previews equal parts.
      const bool preview = i * num_previews % count < num_previews;
      std::error_code error;
      if (context.resuming && fs::exists(map_path, error) &&
          (!preview || fs::exists(preview_path, error))) {
        continue;
      }
      const View& view = views[i];
      const Pinhole camera = view.camera.LimitedTo(options_.max_image_size);
      const Image<int32_t> map = splat::RenderLabels(scene.model,
                                                     camera,
                                                     view.cam_from_world,
                                                     scene.render,
                                                     *context.pool,
                                                     labels);
      if (preview) {
        FREEGS_RETURN_IF_ERROR(
            WritePreview(context.workspace / "undistort" / "images" / view.name,
                         map,
                         preview_path));
      }
      FREEGS_RETURN_IF_ERROR(CreateFolders(map_path.parent_path()));
      FREEGS_RETURN_IF_ERROR(WriteLabels(map_path, EncodeInstances(map)));
    }
    return {};
  }

  static Status WritePreview(const fs::path& photo_path,
                             const Image<int32_t>& map,
                             const fs::path& path) {
    FREEGS_ASSIGN_OR_RETURN(ImageU8 photo, ReadRgb(photo_path));
    if (photo.width() != map.width() || photo.height() != map.height()) {
      photo = Resize(photo, map.width(), map.height());
    }
    FREEGS_RETURN_IF_ERROR(CreateFolders(path.parent_path()));
    return WriteImage(path, OverlayInstances(photo, map));
  }

  Status WriteMetrics(const WorkspaceScene& scene,
                      const semantics::InstanceLabels& labels,
                      const std::vector<semantics::Instance>& instances,
                      const pipeline::ResourceMeter& meter,
                      pipeline::StageContext& context) const {
    const semantics::InstanceClusteringOptions& clustering =
        options_.clustering;
    int num_background = 0;
    nlohmann::json sizes = nlohmann::json::array();
    for (const semantics::Instance& instance : instances) {
      num_background += instance.background;
      sizes.push_back(instance.num_gaussians);
    }
    const pipeline::ResourceUsage usage = meter.Elapsed();
    nlohmann::json metrics = {
        {"num_gaussians", scene.model.size()},
        {"num_instances", labels.num_instances},
        {"num_background", num_background},
        {"scene_radius", labels.scene_radius},
        {"num_clustered", labels.num_clustered},
        {"num_plane_points", labels.num_plane_points},
        {"num_clusters", labels.num_clusters},
        {"noise_before", labels.noise_before},
        {"noise_after", labels.noise_after},
        {"seconds", context.earlier_seconds + usage.wall_seconds},
        {"cpu_seconds", usage.cpu_seconds},
        {"peak_memory_bytes", usage.peak_memory_bytes},
        {"hdbscan",
         {{"min_cluster_size", labels.min_cluster_size},
          {"min_samples", clustering.hdbscan.min_samples},
          {"cluster_selection_epsilon",
           clustering.hdbscan.cluster_selection_epsilon},
          {"max_cluster_size", clustering.hdbscan.max_cluster_size},
          {"method", options_.method}}}};
    context.summary = metrics;
    metrics["instance_sizes"] = std::move(sizes);
    return WriteFileAtomic(context.output / "metrics.json",
                           metrics.dump(1) + "\n");
  }

  BootstrapStageOptions options_;
  uint64_t seed_;
};

}  // namespace

void RegisterBootstrapOptions(BootstrapStageOptions& options,
                              pipeline::OptionTable& table) {
  semantics::InstanceClusteringOptions& clustering = options.clustering;
  table.AddSection("bootstrap",
                   "Phase 2: Gaussians are grouped into instances.");
  table.Add("bootstrap.min_samples",
            &clustering.hdbscan.min_samples,
            {.help = "Neighbours that make a neighbourhood dense: more gives "
                     "rounder clusters and more noise.",
             .min = 1,
             .max = 10000});
  table.Add("bootstrap.min_cluster_size",
            &clustering.hdbscan.min_cluster_size,
            {.help = "Fewest Gaussians of a cluster; 0 takes 0.3 % of all.",
             .min = 0,
             .max = 100000000});
  table.Add("bootstrap.min_gap_ratio",
            &clustering.hdbscan.min_gap_ratio,
            {.help = "Clusters are split across gaps of this many times their "
                     "inner distances; 0 leaves HDBSCAN's choice.",
             .min = 0,
             .max = 1000});
  table.Add("bootstrap.cluster_selection_epsilon",
            &clustering.hdbscan.cluster_selection_epsilon,
            {.help = "Clusters that split at less than this distance stay "
                     "together (scene radii times the weights); 0 always "
                     "splits.",
             .min = 0,
             .max = 1000});
  table.Add("bootstrap.max_cluster_size",
            &clustering.hdbscan.max_cluster_size,
            {.help = "Clusters of more Gaussians are split; 0 is no limit.",
             .min = 0});
  table.Add("bootstrap.method",
            &options.method,
            {.help = "Which clusters of the hierarchy are taken: those of most "
                     "excess of mass, or its leaves (finer).",
             .choices = {"eom", "leaf"}});
  table.Add("bootstrap.position_weight",
            &clustering.space.position_weight,
            {.help = "Weight of positions (in scene radii) when Gaussians are "
                     "compared.",
             .min = 0,
             .max = 1000});
  table.Add("bootstrap.color_weight",
            &clustering.space.color_weight,
            {.help = "Weight of colours (0 to 1) when Gaussians are compared.",
             .min = 0,
             .max = 1000});
  table.Add("bootstrap.color_neighbors",
            &clustering.color_neighbors,
            {.help = "Neighbours over which colours are averaged first.",
             .min = 0,
             .max = 1000});
  table.Add("bootstrap.max_planes",
            &clustering.planes.max_planes,
            {.help = "Large planes (floor, walls, table tops) that become "
                     "instances of their own before clustering; 0 seeks none.",
             .min = 0,
             .max = 1000});
  table.Add("bootstrap.merge_color",
            &clustering.merge_color,
            {.help = "Touching clusters join when their mean colours differ by "
                     "less than this; 0 joins none.",
             .min = 0,
             .max = 2});
  table.Add("bootstrap.merge_distance",
            &clustering.merge_distance,
            {.help = "How near clusters must be to touch, in scene radii.",
             .min = 0,
             .max = 10});
  table.Add("bootstrap.min_crease_contrast",
            &clustering.min_crease_contrast,
            {.help = "Clusters are split at concave creases between parts of "
                     "different colour: concavity (0 to 2) times colour "
                     "difference from which on they are; 0 splits none.",
             .min = 0,
             .max = 10});
  table.Add("bootstrap.noise_distance",
            &clustering.noise_distance,
            {.help = "Noise joins the nearest cluster within this many scene "
                     "radii.",
             .min = 0,
             .max = 1000});
  table.Add("bootstrap.min_instance_size",
            &clustering.min_instance_size,
            {.help = "Instances of fewer Gaussians are dissolved.",
             .min = 1,
             .max = 100000000});
  table.Add("bootstrap.min_opacity",
            &clustering.min_opacity,
            {.help = "Fainter Gaussians are not clustered; they take their "
                     "neighbour's instance.",
             .min = 0,
             .max = 0.99});
  table.Add("bootstrap.max_image_size",
            &options.max_image_size,
            {.help = "Longest side in pixels of the instance maps; 0 is the "
                     "photographs' size.",
             .min = 0,
             .max = 100000});
  table.Add("bootstrap.num_previews",
            &options.num_previews,
            {.help = "Photographs that get a coloured preview.",
             .min = 0,
             .max = 100000});
}

std::unique_ptr<pipeline::Stage> MakeBootstrapStage(
    const BootstrapStageOptions& options, uint64_t seed) {
  return std::make_unique<BootstrapStage>(options, seed);
}

}  // namespace freegs::stages
