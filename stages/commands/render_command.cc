// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/render_command.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string_view>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/json_text.h"
#include "core/parallel.h"
#include "pipeline/logger.h"
#include "pipeline/option_table.h"
#include "pipeline/progress_line.h"
#include "pipeline/system_info.h"
#include "semantics/field/semantic_colors.h"
#include "semantics/instances/hierarchy.h"
#include "splat/render/renderer.h"
#include "stages/scene/depth_image.h"
#include "stages/scene/scene_instances.h"
#include "stages/scene/view_selection.h"
#include "stages/scene/working_frame.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

struct RenderRequest {
  fs::path workspace;
  std::string out;
  std::string cameras;
  std::string what = "color";
  double granularity = 0;  // Of --what instances, where it is given.
  bool has_granularity = false;
  int size = 0;
  int threads = 0;
  bool no_align = false;
};

CommandWords DescribeRender(RenderRequest* request) {
  CommandWords words("render",
                     "Renders the scene from the cameras of its photos, or "
                     "from any others.");
  words.AddArgument(WorkspaceArgument());
  words.AddOption("out",
                  &request->out,
                  {.help = "Folder for the pictures.", .value_name = "DIR"});
  words.AddOption(
      "cameras",
      &request->cameras,
      {.help = "JSON file of cameras; without it, those of the photos.",
       .value_name = "FILE"});
  words.AddOption("what",
                  &request->what,
                  {.help = "What to render.",
                   .choices = {"color", "depth", "instances", "semantics"}});
  words.AddOption("granularity",
                  &request->granularity,
                  {.help = "With --what instances: instances of another "
                           "granularity than bootstrap.granularity, without "
                           "running the stage again.",
                   .min = -100,
                   .max = 100});
  words.AddOption(
      "size",
      &request->size,
      {.help = "Longest side in pixels at most; 0 is the size of training or "
               "of the camera file.",
       .min = 0});
  words.AddOption(
      "threads",
      &request->threads,
      {.help = "Threads to work with; 0 takes one per available core.",
       .min = 0,
       .max = 1024});
  words.AddOption("no-align",
                  &request->no_align,
                  {.help = "The cameras are in the scene's own world frame."});
  words.Require("out");
  return words;
}

StatusOr<RenderRequest> ParseRenderRequest(
    const std::vector<std::string>& arguments) {
  RenderRequest request;
  CommandWords words = DescribeRender(&request);
  FREEGS_ASSIGN_OR_RETURN(const pipeline::OptionTable::CommandLine line,
                          words.Parse(arguments));
  FREEGS_RETURN_IF_ERROR(words.table().Apply(line.settings));
  for (const pipeline::OptionSetting& setting : line.settings) {
    if (setting.name == "granularity") request.has_granularity = true;
  }
  if (request.has_granularity && request.what != "instances") {
    return InvalidArgumentError("--granularity is for --what instances only");
  }
  if (request.no_align && request.cameras.empty()) {
    return InvalidArgumentError("--no-align is for --cameras FILE only");
  }
  request.workspace = line.positional[0];
  return request;
}

// Writes the pictures of one view after another.
class Renderer {
 public:
  Renderer(const WorkspaceScene& scene, fs::path out, ThreadPool* pool)
      : scene_(scene), out_(std::move(out)), pool_(*pool) {}
  virtual ~Renderer() = default;
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
  DepthRenderer(const WorkspaceScene& scene,
                fs::path out,
                ThreadPool* pool,
                const std::vector<View>& views)
      : Renderer(scene, std::move(out), pool),
        range_(InWorldUnits(VisibleDepthRange(scene.model, views))),
        unit_(DepthUnit(range_.far)) {}

  Status WriteScale() const {
    const nlohmann::json scale = {{"unit", unit_},
                                  {"nothing", 0},
                                  {"beyond", 65535},
                                  {"near", range_.near},
                                  {"far", range_.far}};
    return WriteFileAtomic(out_ / "depth.json", JsonText(scale));
  }

  Status Render(const View& view, const std::string& name) override {
    ImageF depth = RenderView(view).depth;
    for (size_t k = 0; k < depth.size(); ++k) {
      depth.data()[k] *= static_cast<float>(scene_.frame.unit);
    }
    FREEGS_ASSIGN_OR_RETURN(const fs::path path, File(name));
    FREEGS_RETURN_IF_ERROR(WriteLabels(path, EncodeDepth(depth, unit_)));
    FREEGS_ASSIGN_OR_RETURN(const fs::path preview,
                            File(fs::path("preview") / name));
    return WriteImage(preview, ColorDepth(depth, range_));
  }

 private:
  DepthRange InWorldUnits(const DepthRange& range) const {
    return {range.near * scene_.frame.unit, range.far * scene_.frame.unit};
  }

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
    const Image<int32_t> labels = splat::RenderLabels(scene_.model,
                                                      view.camera,
                                                      view.cam_from_world,
                                                      scene_.render,
                                                      pool_,
                                                      labels_);
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
                         "bootstrap again with semantics");
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

StatusOr<std::unique_ptr<Renderer>> MakeRenderer(const RenderRequest& request,
                                                 const WorkspaceScene& scene,
                                                 const std::vector<View>& views,
                                                 ThreadPool* pool) {
  if (request.what == "depth") {
    auto renderer =
        std::make_unique<DepthRenderer>(scene, request.out, pool, views);
    FREEGS_RETURN_IF_ERROR(renderer->WriteScale());
    return std::unique_ptr<Renderer>(std::move(renderer));
  }
  if (request.what == "instances") {
    FREEGS_ASSIGN_OR_RETURN(std::vector<int32_t> labels,
                            LabelsToRender(request, scene.model.size()));
    return std::unique_ptr<Renderer>(std::make_unique<InstanceRenderer>(
        scene, request.out, pool, std::move(labels)));
  }
  if (request.what == "semantics") {
    FREEGS_ASSIGN_OR_RETURN(
        std::vector<float> colors,
        ReadSemanticColors(request.workspace, scene.model.size(), *pool));
    return std::unique_ptr<Renderer>(std::make_unique<SemanticRenderer>(
        scene, request.out, pool, std::move(colors)));
  }
  return std::unique_ptr<Renderer>(
      std::make_unique<ColorRenderer>(scene, request.out, pool));
}

}  // namespace

CommandWords RenderWords() { return KeepWords<RenderRequest>(DescribeRender); }

Status RunRenderCommand(const std::vector<std::string>& arguments,
                        CommandContext& context) {
  FREEGS_ASSIGN_OR_RETURN(const RenderRequest request,
                          ParseRenderRequest(arguments));
  WarnOfRun(request.workspace, context);
  FREEGS_ASSIGN_OR_RETURN(const WorkspaceScene scene,
                          ReadWorkspaceScene(request.workspace));
  FREEGS_ASSIGN_OR_RETURN(
      const std::vector<View> views,
      ViewsToRender(
          scene,
          {.cameras = request.cameras,
           .align = !request.no_align,
           .max_side = request.size,
           .photo_max_side =
               request.size > 0 ? request.size : scene.training_max_side,
           .command = "render"},
          context.err));
  FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                          OutputNames(views, ".png"));
  FREEGS_RETURN_IF_ERROR(PrepareOutputFolder(request.out));
  ThreadPool pool(pipeline::WorkingThreads(request.threads));
  FREEGS_ASSIGN_OR_RETURN(const std::unique_ptr<Renderer> renderer,
                          MakeRenderer(request, scene, views, &pool));
  FREEGS_RETURN_IF_ERROR(
      CheckVisible(scene.model, views, scene.render, "render", pool));

  const bool terminal =
      &context.err == &std::cerr && isatty(STDERR_FILENO) != 0;
  pipeline::Logger logger(context.err, terminal, {});
  pipeline::ProgressLine progress(&logger, "render");
  for (size_t i = 0; i < views.size(); ++i) {
    if (context.cancellation.cancelled()) {
      return InterruptedError("render: stopped after " + std::to_string(i) +
                              " of " + std::to_string(views.size()) +
                              " pictures");
    }
    FREEGS_RETURN_IF_ERROR(renderer->Render(views[i], names[i]));
    progress.Report({request.what,
                     static_cast<double>(i + 1),
                     static_cast<double>(views.size()),
                     names[i]});
  }
  context.out << views.size() << " pictures in " << request.out << "\n";
  return Status();
}

}  // namespace freegs::stages
