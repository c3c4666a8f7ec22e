// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/export_command.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/io/files.h"
#include "core/number_text.h"
#include "core/parallel.h"
#include "core/text.h"
#include "pipeline/logger.h"
#include "pipeline/progress_line.h"
#include "pipeline/system_info.h"
#include "semantics/instances/instances_json.h"
#include "sfm/scene/model_io.h"
#include "splat/scene/ply_io.h"
#include "splat/scene/splat_format.h"
#include "splat/scene/spz_format.h"
#include "stages/commands/export_request.h"
#include "stages/export/instance_files.h"
#include "stages/scene/scene_instances.h"
#include "stages/scene/view_selection.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// Only a PLY can say where the model lies in the world.
Status WriteGaussians(const fs::path& path,
                      const splat::GaussianModel& model,
                      const Eigen::Vector3d& offset) {
  const std::string suffix = LowerSuffix(path);
  if (suffix == ".spz") return splat::WriteSpz(path, model);
  if (suffix == ".splat") return splat::WriteSplat(path, model);
  return splat::WritePly(path, model, offset);
}

void TellOffset(const Eigen::Vector3d& offset, CommandContext& context) {
  if (offset.isZero(0)) return;
  context.out << "positions count from " << FormatSignificant(offset.x(), 17)
              << " " << FormatSignificant(offset.y(), 17) << " "
              << FormatSignificant(offset.z(), 17)
              << ", since float32 numbers of the world would be too coarse\n";
}

// Gives the model the colours and the degree that the request asks for.
void Recolor(const ExportRequest& request,
             const std::vector<int32_t>& labels,
             splat::GaussianModel* model) {
  if (request.what == "instances") *model = ColorByInstance(*model, labels);
  if (request.sh_degree == "scene") return;
  model->SetShDegree(request.sh_degree[0] - '0');
}

Status ExportScene(const ExportRequest& request, CommandContext& context) {
  FREEGS_ASSIGN_OR_RETURN(const fs::path path, PrepareOutputFile(request.out));
  FREEGS_ASSIGN_OR_RETURN(splat::PlacedModel world,
                          ReadWorkspaceModel(request.workspace));
  splat::GaussianModel& model = world.model;
  std::vector<int32_t> labels;
  if (!request.choice.everything() || request.what == "instances") {
    FREEGS_ASSIGN_OR_RETURN(
        labels, ReadInstanceLabels(request.workspace, model.size()));
  }
  Recolor(request, labels, &model);
  if (!request.choice.everything()) {
    FREEGS_ASSIGN_OR_RETURN(const std::vector<uint32_t> chosen,
                            ChosenGaussians(request.choice, labels));
    model.Select(chosen);
  }
  FREEGS_RETURN_IF_ERROR(WriteGaussians(path, model, world.offset));
  context.out << model.size() << " Gaussians in " << request.out << "\n";
  TellOffset(world.offset, context);
  return Status();
}

// The number of files ID.format in the folder that are of other instances than
// those just written, such as what an earlier export left there. They stay,
// because they may be somebody's.
size_t CountOtherObjects(const fs::path& folder,
                         const std::string& format,
                         const std::set<std::string>& written) {
  size_t count = 0;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    const fs::path& path = it->path();
    const std::string id = path.stem().string();
    const bool is_id = !id.empty() && std::ranges::all_of(id, IsDigit);
    if (is_id && path.extension() == "." + format &&
        !written.contains(path.filename().string())) {
      ++count;
    }
  }
  return count;
}

Status ExportObjects(const ExportRequest& request, CommandContext& context) {
  const fs::path folder(request.objects);
  FREEGS_RETURN_IF_ERROR(PrepareOutputFolder(folder));
  FREEGS_ASSIGN_OR_RETURN(splat::PlacedModel world,
                          ReadWorkspaceModel(request.workspace));
  FREEGS_ASSIGN_OR_RETURN(
      const std::vector<int32_t> labels,
      ReadInstanceLabels(request.workspace, world.model.size()));
  FREEGS_ASSIGN_OR_RETURN(const std::set<int32_t> chosen,
                          ChosenLabels(request.choice, labels));
  Recolor(request, labels, &world.model);
  std::map<int32_t, splat::GaussianModel> objects;
  for (size_t i = 0; i < labels.size(); ++i) {
    if (!chosen.contains(labels[i])) continue;
    splat::GaussianModel& object = objects[labels[i]];
    object.sh_degree = world.model.sh_degree;
    object.antialiased = world.model.antialiased;
    object.AppendFrom(world.model, i);
  }
  const auto name_of = [&request](int32_t label) {
    return std::to_string(label + 1) + "." + request.format;
  };
  for (const auto& [label, object] : objects) {
    FREEGS_RETURN_IF_ERROR(
        CheckOutputPlace(request.workspace, folder / name_of(label)));
  }
  std::set<std::string> written;
  for (const auto& [label, object] : objects) {
    if (context.cancellation.cancelled()) {
      return InterruptedError("export: stopped");
    }
    const std::string name = name_of(label);
    FREEGS_RETURN_IF_ERROR(WriteGaussians(folder / name, object, world.offset));
    written.insert(name);
  }
  context.out << chosen.size() << " objects in " << request.objects << "\n";
  const size_t others = CountOtherObjects(folder, request.format, written);
  if (others > 0) {
    context.out << "the folder also holds " << others << " ." << request.format
                << " files of instances that are not among them\n";
  }
  TellOffset(world.offset, context);
  return Status();
}

// The instances that the request asks for.
StatusOr<std::vector<semantics::Instance>> ChosenInstances(
    const ExportRequest& request, const std::vector<int32_t>& labels) {
  FREEGS_ASSIGN_OR_RETURN(const std::set<int32_t> chosen,
                          ChosenLabels(request.choice, labels));
  const fs::path path = request.workspace / "bootstrap" / "instances.json";
  FREEGS_ASSIGN_OR_RETURN(std::vector<semantics::Instance> instances,
                          semantics::ReadInstances(path));
  FREEGS_RETURN_IF_ERROR(CheckInstanceIds(instances, labels.size(), path));
  std::erase_if(instances, [&](const semantics::Instance& instance) {
    return !chosen.contains(instance.id - 1);
  });
  return instances;
}

Status ExportBoxes(const ExportRequest& request, CommandContext& context) {
  FREEGS_ASSIGN_OR_RETURN(const fs::path path, PrepareOutputFile(request.out));
  FREEGS_ASSIGN_OR_RETURN(const splat::PlacedModel world,
                          ReadWorkspaceModel(request.workspace));
  FREEGS_ASSIGN_OR_RETURN(
      const std::vector<int32_t> labels,
      ReadInstanceLabels(request.workspace, world.model.size()));
  FREEGS_ASSIGN_OR_RETURN(const std::vector<semantics::Instance> instances,
                          ChosenInstances(request, labels));
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(path, BoxesJson(instances)));
  context.out << instances.size() << " boxes in " << request.out << "\n";
  return Status();
}

Status ExportMasks(const ExportRequest& request, CommandContext& context) {
  FREEGS_ASSIGN_OR_RETURN(const fs::path path, PrepareOutputFile(request.out));
  FREEGS_ASSIGN_OR_RETURN(const WorkspaceScene scene,
                          ReadWorkspaceScene(request.workspace));
  FREEGS_ASSIGN_OR_RETURN(
      const std::vector<int32_t> labels,
      ReadInstanceLabels(request.workspace, scene.model.size()));
  FREEGS_ASSIGN_OR_RETURN(std::vector<semantics::Instance> instances,
                          ChosenInstances(request, labels));
  const std::vector<View> views = PhotoViews(scene);
  ThreadPool pool(pipeline::WorkingThreads(request.threads));
  pipeline::Logger logger(context.err, pipeline::IsTerminal(context.err), {});
  pipeline::ProgressLine progress(&logger, "export");
  CocoMasks masks(std::move(instances));
  for (size_t i = 0; i < views.size(); ++i) {
    if (context.cancellation.cancelled()) {
      return InterruptedError("export: stopped");
    }
    masks.AddPicture(views[i].name,
                     RenderLabels(scene, views[i], labels, pool));
    progress.Report({"masks",
                     static_cast<double>(i + 1),
                     static_cast<double>(views.size()),
                     views[i].name});
  }
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(path, masks.Json()));
  context.out << masks.num_annotations() << " masks of " << views.size()
              << " photos in " << request.out << "\n";
  return Status();
}

// Fails with kInvalidArgument if the folder holds files of a COLMAP model
// beside which a text model is hidden or misread. Programs that find both forms
// read the binary one; some, such as that of 3DGS, do so where only part of its
// files are there. Newer releases of COLMAP read rigs.txt and frames.txt with
// the text files, also where they belong to another model.
Status CheckNothingHidesText(const fs::path& folder) {
  for (const char* const name : {"cameras.bin",
                                 "images.bin",
                                 "points3D.bin",
                                 "rigs.bin",
                                 "frames.bin",
                                 "rigs.txt",
                                 "frames.txt"}) {
    if (IsNameTaken(folder / name)) {
      return InvalidArgumentError(
          folder.string() + ": holds a COLMAP model with " + name +
          ", which would hide the text files that are written; give another "
          "folder");
    }
  }
  return Status();
}

Status ExportColmap(const ExportRequest& request, CommandContext& context) {
  const fs::path sparse = request.workspace / "undistort" / "sparse";
  if (!sfm::DetectModelFormat(sparse)) {
    return BadInputError(sparse.string() +
                         ": no COLMAP model; run stage undistort first");
  }
  FREEGS_RETURN_IF_ERROR(CheckNothingHidesText(request.out));
  FREEGS_RETURN_IF_ERROR(PrepareOutputFolder(request.out));
  FREEGS_ASSIGN_OR_RETURN(const sfm::Reconstruction model,
                          sfm::ReadModel(sparse));
  FREEGS_RETURN_IF_ERROR(
      sfm::WriteModel(request.out, model, sfm::ModelFormat::kText));
  context.out << model.images.size() << " poses and " << model.points3d.size()
              << " points in " << request.out << "\n";
  return Status();
}

}  // namespace

CommandWords ExportWords() { return KeepWords<ExportRequest>(DescribeExport); }

Status RunExportCommand(const std::vector<std::string>& arguments,
                        CommandContext& context) {
  FREEGS_ASSIGN_OR_RETURN(const ExportRequest request,
                          ParseExportRequest(arguments));
  for (const std::string& place : {request.out, request.objects}) {
    FREEGS_RETURN_IF_ERROR(CheckOutputPlace(request.workspace, place));
  }
  WarnOfRun(request.workspace, context);
  if (request.what == "masks") return ExportMasks(request, context);
  if (request.what == "boxes") return ExportBoxes(request, context);
  if (request.what == "colmap") return ExportColmap(request, context);
  if (!request.objects.empty()) return ExportObjects(request, context);
  return ExportScene(request, context);
}

}  // namespace freegs::stages
