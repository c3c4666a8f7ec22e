// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/export_stage.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/cancellation.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/number_text.h"
#include "semantics/instances/instances_json.h"
#include "semantics/instances/palette.h"
#include "splat/scene/ply_io.h"
#include "splat/scene/splat_format.h"
#include "splat/scene/spz_format.h"
#include "stages/export/box_wireframe.h"
#include "stages/export/export_forecast.h"
#include "stages/export/html.h"
#include "stages/export/instance_files.h"
#include "stages/export/report_data.h"
#include "stages/export/report_page.h"
#include "stages/export/report_views.h"
#include "stages/scene/depth_image.h"
#include "stages/scene/scene_instances.h"
#include "stages/scene/training_scene.h"
#include "stages/scene/view_selection.h"
#include "stages/scene/working_frame.h"
#include "stages/scene/workspace_scene.h"
#include "stages/viewer/viewer_scene.h"
#include "stages/viewer/web_bundle.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// The page with its pictures and its script should be no larger than what
// people send each other. Base64 makes a third more of this.
constexpr int64_t kMaxPageSplatBytes = 4 << 20;

constexpr uint64_t kMaxBundleBytes = 64 << 20;

// The instances of bootstrap/.
struct SceneInstances {
  std::vector<int32_t> labels;  // Per Gaussian.
  std::vector<semantics::Instance> instances;
};

StatusOr<std::optional<SceneInstances>> ReadSceneInstances(
    const fs::path& workspace, size_t num_gaussians) {
  std::error_code error;
  if (!fs::exists(workspace / "bootstrap" / "idsf.bin", error)) {
    return std::optional<SceneInstances>();
  }
  SceneInstances result;
  FREEGS_ASSIGN_OR_RETURN(result.labels,
                          ReadInstanceLabels(workspace, num_gaussians));
  const fs::path path = workspace / "bootstrap" / "instances.json";
  FREEGS_ASSIGN_OR_RETURN(result.instances, semantics::ReadInstances(path));
  FREEGS_RETURN_IF_ERROR(
      CheckInstanceIds(result.instances, num_gaussians, path));
  return std::optional<SceneInstances>(std::move(result));
}

std::array<uint8_t, 3> InstanceColor(const semantics::Instance& instance) {
  return semantics::PaletteColor(instance.id - 1);
}

// The folder that a stage writes to has another name when the stage has ended,
// so that messages should not name it.
std::string WithoutPrefix(const std::string& text, const std::string& prefix) {
  return text.starts_with(prefix) ? text.substr(prefix.size()) : text;
}

class ExportStage : public pipeline::Stage {
 public:
  explicit ExportStage(const ExportStageOptions& options) : options_(options) {}

  std::string_view name() const override { return "export"; }

  int version() const override { return 7; }

  std::vector<fs::path> Inputs(
      const pipeline::StageContext& context) const override {
    std::vector<fs::path> inputs = {
        "ingest/images.json",
        "undistort/images",
        "undistort/sparse",
        "reconstruct/point_cloud.ply",
        // There is no such file where no exposure was learnt.
        "reconstruct/exposure.json",
        "reconstruct/metrics.json",
        "reconstruct/progress.csv",
        "bootstrap/idsf.bin",
        "bootstrap/instances.json",
        "bootstrap/hierarchy.json"};
    // The report leaves out what stage sfm says of the poses where somebody
    // brought poses and photos of their own for stage undistort.
    std::error_code error;
    if (fs::is_directory(context.workspace / "sfm", error)) {
      inputs.emplace_back("sfm/health.json");
    }
    return inputs;
  }

  pipeline::StageNeed Foretell(const pipeline::StageContext& context,
                               bool /*done*/,
                               pipeline::SceneOutlook* scene) const override {
    return ExportNeed(options_, context.pool->num_threads(), *scene);
  }

  Status Run(pipeline::StageContext& context) override {
    FREEGS_ASSIGN_OR_RETURN(const WorkspaceScene scene,
                            ReadWorkspaceScene(context.workspace));
    FREEGS_ASSIGN_OR_RETURN(
        const std::optional<SceneInstances> found,
        ReadSceneInstances(context.workspace, scene.model.size()));

    FREEGS_RETURN_IF_ERROR(CheckCancelled(context));
    FREEGS_ASSIGN_OR_RETURN(const splat::PlacedModel world,
                            ReadWorkspaceModel(context.workspace));
    const std::string note = FarAwayNote(scene.frame);
    if (!note.empty()) {
      context.log(pipeline::LogLevel::kWarning, note);
    }
    // Each of these files may take seconds.
    FREEGS_RETURN_IF_ERROR(CheckCancelled(context));
    FREEGS_RETURN_IF_ERROR(splat::WritePly(
        context.output / "scene.ply", world.model, world.offset));
    FREEGS_RETURN_IF_ERROR(CheckCancelled(context));
    FREEGS_RETURN_IF_ERROR(
        splat::WriteSplat(context.output / "scene.splat", world.model));
    FREEGS_RETURN_IF_ERROR(CheckCancelled(context));
    // Positions and sizes that do not fit into the format are no fault of the
    // scene.
    const fs::path spz_path = context.output / "scene.spz";
    const Status spz = splat::WriteSpz(spz_path, world.model);
    if (spz.code() == StatusCode::kBadInput) {
      context.log(pipeline::LogLevel::kWarning,
                  "no scene.spz: " +
                      WithoutPrefix(spz.message(), spz_path.string() + ": "));
    } else {
      FREEGS_RETURN_IF_ERROR(spz);
    }
    FREEGS_RETURN_IF_ERROR(CheckCancelled(context));
    if (found) {
      FREEGS_RETURN_IF_ERROR(WriteInstances(world, *found, context));
      FREEGS_RETURN_IF_ERROR(WriteMasks(scene, *found, context));
    } else {
      context.log(pipeline::LogLevel::kWarning,
                  "bootstrap/ has no instances; masks and boxes are "
                  "left out");
    }
    FREEGS_RETURN_IF_ERROR(CheckCancelled(context));
    return WriteReport(scene, found, context);
  }

 private:
  static Status WriteInstances(const splat::PlacedModel& world,
                               const SceneInstances& found,
                               pipeline::StageContext& context) {
    FREEGS_RETURN_IF_ERROR(
        splat::WritePly(context.output / "instances.ply",
                        ColorByInstance(world.model, found.labels),
                        world.offset));
    FREEGS_RETURN_IF_ERROR(WriteFileAtomic(context.output / "boxes.json",
                                           BoxesJson(found.instances)));
    // The box of a floor would hide all others.
    std::vector<ColoredBox> boxes;
    for (const semantics::Instance& instance : found.instances) {
      if (instance.background) continue;
      boxes.push_back({instance.obb, InstanceColor(instance)});
    }
    context.summary["instances"] = found.instances.size();
    return WriteFileAtomic(context.output / "boxes.ply",
                           SerializeBoxWireframes(boxes, world.offset));
  }

  Status WriteMasks(const WorkspaceScene& scene,
                    const SceneInstances& found,
                    pipeline::StageContext& context) const {
    std::vector<View> views = scene.holdout;
    const std::vector<View> train =
        SpreadViews(scene.train, options_.mask_views);
    views.insert(views.end(), train.begin(), train.end());
    FREEGS_ASSIGN_OR_RETURN(const auto names,
                            OutputNameByView(PhotoViews(scene), ""));
    for (size_t i = 0; i < views.size(); ++i) {
      FREEGS_RETURN_IF_ERROR(CheckCancelled(context));
      context.progress({"masks",
                        static_cast<double>(i),
                        static_cast<double>(views.size()),
                        ""});
      const Image<int32_t> map =
          RenderLabels(scene, views[i], found.labels, *context.pool);
      const std::set<int32_t> seen(map.data(), map.data() + map.size());
      const fs::path folder =
          context.output / "masks" / names.at(views[i].name);
      FREEGS_RETURN_IF_ERROR(CreateFolders(folder));
      for (const int32_t label : seen) {
        if (label < 0) continue;
        FREEGS_RETURN_IF_ERROR(
            WriteImage(folder / (std::to_string(label + 1) + ".png"),
                       InstanceMask(map, label)));
      }
    }
    context.summary["mask_views"] = views.size();
    return Status();
  }

  Status WriteReport(const WorkspaceScene& scene,
                     const std::optional<SceneInstances>& found,
                     pipeline::StageContext& context) const {
    ReportData data = GatherReportData(context.workspace, scene.model.size());
    if (IsSceneReplaced(context.workspace)) {
      context.log(pipeline::LogLevel::kWarning,
                  "reconstruct/point_cloud.ply is not as stage reconstruct "
                  "wrote it; the report leaves out the PSNR and all else that "
                  "was measured of the scene before");
    }
    if (found) FillInstances(found->instances, &data);
    data.views_are_holdout = !scene.holdout.empty();
    const std::vector<View> views =
        SpreadViews(data.views_are_holdout ? scene.holdout : scene.train,
                    options_.report_views);
    const DepthRange depth_range = VisibleDepthRange(scene.model, views);
    const std::map<std::string, ViewFigures> figures =
        ReadHoldoutFigures(context.workspace);
    const fs::path folder = context.output / "report" / "views";
    FREEGS_RETURN_IF_ERROR(CreateFolders(folder));
    std::span<const int32_t> labels;
    if (found) labels = found->labels;
    for (size_t i = 0; i < views.size(); ++i) {
      FREEGS_RETURN_IF_ERROR(CheckCancelled(context));
      context.progress({"report",
                        static_cast<double>(i),
                        static_cast<double>(views.size()),
                        ""});
      FREEGS_ASSIGN_OR_RETURN(ReportView view,
                              WriteReportView(scene,
                                              views[i],
                                              depth_range,
                                              labels,
                                              context.workspace / "undistort" /
                                                  "images" / views[i].name,
                                              folder,
                                              std::to_string(i + 1),
                                              *context.pool));
      const auto measured = figures.find(view.name);
      if (measured != figures.end()) {
        view.psnr = measured->second.psnr;
        view.ssim = measured->second.ssim;
      }
      data.views.push_back(std::move(view));
    }
    FREEGS_RETURN_IF_ERROR(CheckCancelled(context));
    FREEGS_RETURN_IF_ERROR(WriteViewer(context, &data));
    ListFiles(context.output, &data);
    context.summary["report_views"] = views.size();
    return WriteFileAtomic(context.output / "report" / "index.html",
                           RenderReportPage(data));
  }

  // The scene and the script of the 3D view. Without the script, the page says
  // why it has no such view.
  static Status WriteViewer(pipeline::StageContext& context, ReportData* data) {
    const StatusOr<fs::path> bundle = FindWebBundle();
    if (!bundle.ok()) {
      data->no_viewer =
          "the program that made this page was built without Node.js.";
      context.log(pipeline::LogLevel::kWarning, bundle.status().message());
      return Status();
    }
    const fs::path report = context.output / "report";
    for (const char* name : {"viewer.js", "viewer.css", "licenses.txt"}) {
      FREEGS_ASSIGN_OR_RETURN(const std::string bytes,
                              ReadFile(*bundle / name, kMaxBundleBytes));
      FREEGS_RETURN_IF_ERROR(WriteFileAtomic(report / name, bytes));
    }
    ViewerSceneOptions options;
    options.max_bytes = kMaxPageSplatBytes;
    options.cancellation = context.cancellation;
    for (const ReportView& view : data->views) {
      if (!view.photo.empty()) options.pictures[view.name] = view.photo;
    }
    FREEGS_ASSIGN_OR_RETURN(const ViewerScene scene,
                            MakeViewerScene(context.workspace, options));
    data->has_viewer = true;
    FREEGS_RETURN_IF_ERROR(CheckCancelled(context));
    return WriteFileAtomic(report / "scene.js", ViewerSceneScript(scene));
  }

  static void FillInstances(const std::vector<semantics::Instance>& instances,
                            ReportData* data) {
    data->has_instances = true;
    int background = 0;
    for (const semantics::Instance& instance : instances) {
      ReportInstance row;
      row.id = instance.id;
      row.color = InstanceColor(instance);
      row.num_gaussians = instance.num_gaussians;
      const Eigen::Vector3d& size = instance.obb.size;
      row.box_size = {size.x(), size.y(), size.z()};
      for (const std::string& word : instance.words) {
        row.words += (row.words.empty() ? "" : ", ") + word;
      }
      if (instance.background) {
        row.words += row.words.empty() ? "background" : " (background)";
        ++background;
      }
      data->instances.push_back(std::move(row));
    }
    for (ReportFigure& figure : data->figures) {
      if (figure.name != kInstancesFigure) continue;
      figure.value = FormatCount(std::ssize(instances));
      if (background > 0) {
        figure.note = std::to_string(background) + " of them background";
      }
    }
  }

  static void ListFiles(const fs::path& output, ReportData* data) {
    const std::pair<const char*, const char*> known[] = {
        {"scene.ply", "the scene, for any 3D Gaussian Splatting viewer"},
        {"scene.splat", "the scene, for web viewers"},
        {"scene.spz", "the scene, compressed, for web viewers and others"},
        {"instances.ply", "the scene in its instances' colours"},
        {"boxes.json", "boxes of the instances"},
        {"boxes.ply", "boxes as a mesh"}};
    for (const auto& [name, what] : known) {
      std::error_code error;
      const uintmax_t bytes = fs::file_size(output / name, error);
      if (error) continue;
      data->files.push_back({std::string("../") + name, what, bytes});
    }
  }

  static Status CheckCancelled(const pipeline::StageContext& context) {
    return IsCancelled(context.cancellation) ? InterruptedError("stopped")
                                             : Status();
  }

  ExportStageOptions options_;
};

}  // namespace

std::unique_ptr<pipeline::Stage> MakeExportStage(
    const ExportStageOptions& options) {
  return std::make_unique<ExportStage>(options);
}

}  // namespace freegs::stages
