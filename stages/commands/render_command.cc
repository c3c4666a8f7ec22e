// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/render_command.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <ostream>
#include <set>
#include <string>
#include <string_view>
#include <system_error>

#include <nlohmann/json.hpp>

#include "core/function_ref.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/json_text.h"
#include "core/parallel.h"
#include "pipeline/logger.h"
#include "pipeline/progress_line.h"
#include "pipeline/system_info.h"
#include "semantics/field/semantic_colors.h"
#include "semantics/instances/hierarchy.h"
#include "splat/render/renderer.h"
#include "stages/commands/render_request.h"
#include "stages/film/film_picture.h"
#include "stages/film/film_views.h"
#include "stages/film/film_writer.h"
#include "stages/film/rendered_frames.h"
#include "stages/scene/depth_image.h"
#include "stages/scene/depth_scale.h"
#include "stages/scene/rendered_cameras.h"
#include "stages/scene/scene_instances.h"
#include "stages/scene/view_selection.h"
#include "stages/scene/working_frame.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// Writes the pictures of one view after another.
class Renderer {
 public:
  Renderer(const WorkspaceScene& scene, fs::path out, ThreadPool* pool)
      : scene_(scene), out_(std::move(out)), pool_(*pool) {}
  virtual ~Renderer() = default;

  // Before the pictures of these names are rendered.
  virtual Status Begin(const std::vector<std::string>& /*names*/) {
    return Status();
  }
  virtual Status Render(const View& view, const std::string& name) = 0;

 protected:
  // The path of a picture. Creates its folder.
  StatusOr<fs::path> File(const fs::path& name) const {
    const fs::path path = out_ / name;
    FREEGS_RETURN_IF_ERROR(CreateFolders(path.parent_path()));
    return path;
  }

  splat::RenderedView RenderView(const View& view) {
    return splat::RenderView(
        scene_.model, view.camera, view.cam_from_world, scene_.render, pool_);
  }

  const WorkspaceScene& scene_;
  const fs::path out_;
  ThreadPool& pool_;
};

class ColorRenderer : public Renderer {
 public:
  using Renderer::Renderer;

  Status Render(const View& view, const std::string& name) override {
    FREEGS_ASSIGN_OR_RETURN(const fs::path path, File(name));
    return WriteImage(path, ToU8(RenderView(view).color));
  }
};

class DepthRenderer : public Renderer {
 public:
  // world_unit: the length of the scene's unit, in that of the pictures.
  DepthRenderer(const WorkspaceScene& scene,
                fs::path out,
                ThreadPool* pool,
                const std::vector<View>& views,
                double world_unit)
      : Renderer(scene, std::move(out), pool),
        world_unit_(world_unit),
        range_(InWorldUnits(VisibleDepthRange(scene.model, views))),
        unit_(DepthUnit(range_.far)) {}

  Status Begin(const std::vector<std::string>& names) override {
    return WriteDepthScale(out_, unit_, range_, names);
  }

  Status Render(const View& view, const std::string& name) override {
    ImageF depth = RenderView(view).depth;
    for (size_t k = 0; k < depth.size(); ++k) {
      depth.data()[k] *= static_cast<float>(world_unit_);
    }
    FREEGS_ASSIGN_OR_RETURN(const fs::path path, File(name));
    FREEGS_RETURN_IF_ERROR(WriteLabels(path, EncodeDepth(depth, unit_)));
    FREEGS_ASSIGN_OR_RETURN(const fs::path preview,
                            File(fs::path("preview") / name));
    return WriteImage(preview, ColorDepth(depth, range_));
  }

 private:
  DepthRange InWorldUnits(const DepthRange& range) const {
    return {range.near * world_unit_, range.far * world_unit_};
  }

  const double world_unit_;
  const DepthRange range_;
  const double unit_;
};

class InstanceRenderer : public Renderer {
 public:
  InstanceRenderer(const WorkspaceScene& scene,
                   fs::path out,
                   ThreadPool* pool,
                   std::vector<int32_t> labels)
      : Renderer(scene, std::move(out), pool), labels_(std::move(labels)) {}

  Status Render(const View& view, const std::string& name) override {
    const Image<int32_t> labels = RenderLabels(scene_, view, labels_, pool_);
    FREEGS_ASSIGN_OR_RETURN(const fs::path path, File(name));
    FREEGS_RETURN_IF_ERROR(WriteLabels(path, EncodeInstances(labels)));
    FREEGS_ASSIGN_OR_RETURN(const fs::path preview,
                            File(fs::path("preview") / name));
    return WriteImage(preview, ColorInstances(labels));
  }

 private:
  const std::vector<int32_t> labels_;
};

class SemanticRenderer : public Renderer {
 public:
  SemanticRenderer(const WorkspaceScene& scene,
                   fs::path out,
                   ThreadPool* pool,
                   std::vector<float> colors)
      : Renderer(scene, std::move(out), pool), colors_(std::move(colors)) {}

  Status Render(const View& view, const std::string& name) override {
    const splat::RenderedView rendered =
        splat::RenderView(scene_.model,
                          view.camera,
                          view.cam_from_world,
                          scene_.render,
                          pool_,
                          {.values = colors_, .channels = 3});
    FREEGS_ASSIGN_OR_RETURN(const fs::path path, File(name));
    return WriteImage(path, ToU8(rendered.features));
  }

 private:
  const std::vector<float> colors_;  // N x 3.
};

StatusOr<std::vector<float>> ReadSemanticColors(const fs::path& workspace,
                                                size_t num_gaussians,
                                                ThreadPool& pool) {
  FREEGS_ASSIGN_OR_RETURN(const semantics::Idsf idsf,
                          ReadSemanticField(workspace, num_gaussians));
  if (idsf.feature_dim == 0) {
    return BadInputError((workspace / "bootstrap" / "idsf.bin").string() +
                         ": holds instances but no semantic vectors; run stage "
                         "bootstrap again with --bootstrap.mode lift");
  }
  return semantics::SemanticColors(idsf.features, idsf.feature_dim, pool);
}

StatusOr<std::vector<int32_t>> LabelsToRender(const RenderRequest& request,
                                              size_t num_gaussians) {
  if (!request.has_granularity) {
    return ReadInstanceLabels(request.workspace, num_gaussians);
  }
  FREEGS_ASSIGN_OR_RETURN(const semantics::Hierarchy hierarchy,
                          ReadSceneHierarchy(request.workspace, num_gaussians));
  return semantics::CutHierarchy(hierarchy, request.granularity)
      .label_of_gaussian;
}

// The scene, and per Gaussian what the pictures show of it.
struct SceneToRender {
  WorkspaceScene scene;
  std::vector<int32_t> labels;         // For instances; else empty.
  std::vector<float> semantic_colors;  // N x 3 for semantics; else empty.
};

// Keeps only the Gaussians that are listed, in ascending order.
void SelectGaussians(const std::vector<uint32_t>& kept, SceneToRender* shown) {
  shown->scene.model.Select(kept);
  for (size_t k = 0; k < kept.size(); ++k) {
    if (!shown->labels.empty()) shown->labels[k] = shown->labels[kept[k]];
    if (shown->semantic_colors.empty()) continue;
    for (size_t c = 0; c < 3; ++c) {
      shown->semantic_colors[3 * k + c] =
          shown->semantic_colors[3 * kept[k] + c];
    }
  }
  if (!shown->labels.empty()) shown->labels.resize(kept.size());
  if (!shown->semantic_colors.empty()) {
    shown->semantic_colors.resize(3 * kept.size());
  }
}

StatusOr<SceneToRender> ReadSceneToRender(const RenderRequest& request,
                                          ThreadPool& pool) {
  SceneToRender shown;
  FREEGS_ASSIGN_OR_RETURN(shown.scene, ReadWorkspaceScene(request.workspace));
  const size_t num_gaussians = shown.scene.model.size();
  if (request.what == "instances" || request.what == "both") {
    FREEGS_ASSIGN_OR_RETURN(shown.labels,
                            LabelsToRender(request, num_gaussians));
  }
  if (request.what == "semantics") {
    FREEGS_ASSIGN_OR_RETURN(
        shown.semantic_colors,
        ReadSemanticColors(request.workspace, num_gaussians, pool));
  }
  if (request.choice.everything()) return shown;
  // Ids are those of instances.json whatever the granularity of the picture.
  FREEGS_ASSIGN_OR_RETURN(const std::vector<int32_t> labels,
                          ReadInstanceLabels(request.workspace, num_gaussians));
  FREEGS_ASSIGN_OR_RETURN(const std::vector<uint32_t> kept,
                          ChosenGaussians(request.choice, labels));
  SelectGaussians(kept, &shown);
  return shown;
}

std::unique_ptr<Renderer> MakeRenderer(const RenderRequest& request,
                                       const SceneToRender& shown,
                                       const SelectedViews& selected,
                                       ThreadPool* pool) {
  const WorkspaceScene& scene = shown.scene;
  if (request.what == "depth") {
    return std::make_unique<DepthRenderer>(scene,
                                           request.out,
                                           pool,
                                           selected.views,
                                           selected.world_from_scene.scale);
  }
  if (request.what == "instances") {
    return std::make_unique<InstanceRenderer>(
        scene, request.out, pool, shown.labels);
  }
  if (request.what == "semantics") {
    return std::make_unique<SemanticRenderer>(
        scene, request.out, pool, shown.semantic_colors);
  }
  return std::make_unique<ColorRenderer>(scene, request.out, pool);
}

// The poses that a way of the camera goes through, in the scene's frame.
StatusOr<SelectedViews> KeyViews(const RenderRequest& request,
                                 const WorkspaceScene& scene,
                                 CommandContext& context) {
  const bool file = !request.path.empty() && request.path != "orbit" &&
                    request.path != "photos";
  return ViewsToRender(
      scene,
      {.cameras = file ? request.path : request.cameras,
       .align = !request.no_align,
       .only_test = file,
       .max_side = request.size,
       .photo_max_side =
           request.size > 0 ? request.size : scene.training_max_side,
       .command = "render"},
      context.err);
}

// The views to render. The camera circles an object when all that is not the
// object has been taken out of the scene.
StatusOr<SelectedViews> ViewsOf(const RenderRequest& request,
                                const WorkspaceScene& scene,
                                CommandContext& context) {
  FREEGS_ASSIGN_OR_RETURN(SelectedViews selected,
                          KeyViews(request, scene, context));
  if (request.path.empty()) return selected;
  const std::vector<View> keys = std::move(selected.views);
  if (keys.empty()) {
    return BadInputError("render: there is no pose for --path " + request.path);
  }
  const int num_frames = request.num_frames();
  if (request.path == "orbit") {
    selected.views = request.choice.only.empty()
                         ? OrbitOfScene(keys, num_frames)
                         : OrbitOfObject(scene.model, keys, num_frames);
  } else {
    selected.views = request.path == "photos" ? PathOfPhotos(keys, num_frames)
                                              : PathThrough(keys, num_frames);
  }
  return selected;
}

// Calls `work` for each view, and reports progress.
Status ForEachView(const std::vector<View>& views,
                   const std::string& step,
                   CommandContext& context,
                   FunctionRef<Status(size_t)> work) {
  pipeline::Logger logger(context.err, pipeline::IsTerminal(context.err), {});
  pipeline::ProgressLine progress(&logger, "render");
  for (size_t i = 0; i < views.size(); ++i) {
    if (context.cancellation.cancelled()) {
      return InterruptedError("render: stopped after " + std::to_string(i) +
                              " of " + std::to_string(views.size()) +
                              " pictures");
    }
    FREEGS_RETURN_IF_ERROR(work(i));
    progress.Report({step,
                     static_cast<double>(i + 1),
                     static_cast<double>(views.size()),
                     views[i].name});
  }
  return Status();
}

bool HasPreviews(const RenderRequest& request) {
  return request.what == "depth" || request.what == "instances";
}

// Checks the places of all pictures, whose names may have folders.
Status CheckPicturePlaces(const RenderRequest& request,
                          const std::vector<std::string>& names) {
  std::set<fs::path> folders;
  std::set<std::string> previews;
  for (const std::string& name : names) {
    folders.insert((fs::path(request.out) / name).parent_path());
    if (!HasPreviews(request)) continue;
    const fs::path preview = fs::path("preview") / name;
    folders.insert((fs::path(request.out) / preview).parent_path());
    previews.insert(preview.string());
  }
  for (const std::string& name : names) {
    if (previews.contains(name)) {
      return InvalidArgumentError(
          name +
          ": a picture has the place of the preview of another one; "
          "photos in a folder \"preview\" cannot be rendered so");
    }
  }
  for (const fs::path& folder : folders) {
    FREEGS_RETURN_IF_ERROR(CheckOutputPlace(request.workspace, folder));
  }
  return Status();
}

Status WritePictures(const RenderRequest& request,
                     const SceneToRender& shown,
                     const SelectedViews& selected,
                     ThreadPool& pool,
                     CommandContext& context) {
  const std::vector<View>& views = selected.views;
  FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                          OutputNames(views, ".png"));
  FREEGS_RETURN_IF_ERROR(CheckPicturePlaces(request, names));
  const std::unique_ptr<Renderer> renderer =
      MakeRenderer(request, shown, selected, &pool);
  FREEGS_RETURN_IF_ERROR(renderer->Begin(names));
  if (request.path.empty()) {
    FREEGS_RETURN_IF_ERROR(
        ForgetReplacedFrames(request.out, names, HasPreviews(request)));
  }
  const fs::path cameras = fs::path(request.out) / "rendered_cameras.json";
  std::error_code error;
  fs::remove(cameras, error);  // Those of other pictures.
  FREEGS_RETURN_IF_ERROR(
      ForEachView(views, request.what, context, [&](size_t i) {
        return renderer->Render(views[i], names[i]);
      }));
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(
      cameras,
      JsonText(RenderedCameras(views, names, selected.world_from_scene))));
  context.out << views.size() << " pictures in " << request.out << "\n";
  if (request.path.empty()) return Status();
  FREEGS_ASSIGN_OR_RETURN(
      const std::string removed,
      RemoveLaterFrames(request.out, views.size(), HasPreviews(request)));
  context.out << removed;
  return Status();
}

Status WriteFilm(const RenderRequest& request,
                 const SceneToRender& shown,
                 const std::vector<View>& views,
                 ThreadPool& pool,
                 CommandContext& context) {
  constexpr int kDepthViews = 24;
  FilmContent content;
  content.what = request.what;
  content.labels = shown.labels;
  content.semantic_colors = shown.semantic_colors;
  if (request.what == "depth") {
    content.depth_range =
        VisibleDepthRange(shown.scene.model, SpreadViews(views, kDepthViews));
  }
  const Pinhole& camera = views.front().camera;
  const int width = request.what == "both" ? 2 * camera.width : camera.width;
  FREEGS_ASSIGN_OR_RETURN(
      const std::unique_ptr<FilmWriter> film,
      FilmWriter::Open(request.video, width, camera.height, request.fps));
  FREEGS_RETURN_IF_ERROR(ForEachView(views, "film", context, [&](size_t i) {
    return film->Write(FilmPicture(shown.scene, content, views[i], pool));
  }));
  FREEGS_RETURN_IF_ERROR(film->Close());
  context.out << views.size() << " pictures of " << width << " x "
              << camera.height << " in " << request.video << "\n";
  return Status();
}

}  // namespace

CommandWords RenderWords() { return KeepWords<RenderRequest>(DescribeRender); }

Status RunRenderCommand(const std::vector<std::string>& arguments,
                        CommandContext& context) {
  FREEGS_ASSIGN_OR_RETURN(RenderRequest request, ParseRenderRequest(arguments));
  for (const std::string& place : {request.out, request.video}) {
    FREEGS_RETURN_IF_ERROR(CheckOutputPlace(request.workspace, place));
  }
  if (!request.video.empty()) {
    FREEGS_RETURN_IF_ERROR(CheckFilmPath(request.video));
    FREEGS_ASSIGN_OR_RETURN(const fs::path film,
                            PrepareOutputFile(request.video));
    request.video = film.string();
  }
  WarnOfRun(request.workspace, context);
  ThreadPool pool(pipeline::WorkingThreads(request.threads));
  FREEGS_ASSIGN_OR_RETURN(const SceneToRender shown,
                          ReadSceneToRender(request, pool));
  const WorkspaceScene& scene = shown.scene;
  FREEGS_ASSIGN_OR_RETURN(const SelectedViews selected,
                          ViewsOf(request, scene, context));
  const std::vector<View>& views = selected.views;
  if (!request.out.empty()) {
    FREEGS_RETURN_IF_ERROR(PrepareOutputFolder(request.out));
  }
  const Status visible =
      CheckVisible(scene.model, views, scene.render, pool).Annotated("render");
  const bool about_sight = visible.code() == StatusCode::kUnusableResult;
  if (about_sight && !request.choice.everything()) {
    context.err
        << "render: none of the views shows anything of these objects\n";
  } else {
    FREEGS_RETURN_IF_ERROR(visible);
  }
  if (!request.out.empty()) {
    FREEGS_RETURN_IF_ERROR(
        WritePictures(request, shown, selected, pool, context));
  }
  if (request.video.empty()) return Status();
  return WriteFilm(request, shown, views, pool, context);
}

}  // namespace freegs::stages
