// SPDX-License-Identifier: BSD-3-Clause

#include "stages/viewer/viewer_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <span>
#include <system_error>
#include <utility>

#include "core/base64.h"
#include "core/io/json_text.h"
#include "semantics/instances/hierarchy.h"
#include "semantics/instances/instances.h"
#include "semantics/instances/instances_json.h"
#include "semantics/instances/palette.h"
#include "splat/scene/spz_format.h"
#include "stages/scene/scene_instances.h"
#include "stages/scene/workspace_scene.h"
#include "stages/viewer/viewer_levels.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int32_t kNoPart = 65535;

// The largest coordinate that a Gaussian may have, in units of the frame. The
// coordinates of a part then have at least 8 bits of fraction: .spz has 24 bits
// for the farthest of them.
constexpr float kFarthest = 32767;

// Nothing is brought nearer than this, about a hundred times as far away as
// what cameras usually look at.
constexpr float kFar = 500;

json Vector(const Eigen::Vector3d& v) {
  return json::array({v.x(), v.y(), v.z()});
}

struct Objects {
  std::vector<semantics::Instance> instances;
  std::vector<int32_t> labels;  // Per Gaussian.
  ViewerLevels levels;          // Empty when there is no hierarchy.
};

StatusOr<Objects> ReadObjects(const fs::path& workspace, size_t num_gaussians) {
  Objects objects;
  objects.labels.assign(num_gaussians, -1);
  const fs::path folder = workspace / "bootstrap";
  std::error_code error;
  if (!fs::exists(folder / "idsf.bin", error)) return objects;
  FREEGS_ASSIGN_OR_RETURN(objects.labels,
                          ReadInstanceLabels(workspace, num_gaussians));
  FREEGS_ASSIGN_OR_RETURN(objects.instances,
                          semantics::ReadInstances(folder / "instances.json"));
  FREEGS_RETURN_IF_ERROR(CheckInstanceIds(
      objects.instances, num_gaussians, folder / "instances.json"));
  if (!fs::exists(folder / "hierarchy.json", error)) return objects;
  FREEGS_ASSIGN_OR_RETURN(const semantics::Hierarchy hierarchy,
                          ReadSceneHierarchy(workspace, num_gaussians));
  if (hierarchy.tree.num_leaves > kNoPart) return objects;
  int32_t num_labels = 0;
  for (const int32_t label : objects.labels) {
    num_labels = std::max(num_labels, label + 1);
  }
  objects.levels = MakeViewerLevels(hierarchy, objects.labels, num_labels);
  return objects;
}

json PhotosJson(const WorkspaceScene& scene,
                const std::map<std::string, std::string>& pictures) {
  json photos = json::array();
  const auto add = [&](const View& view, bool holdout) {
    const auto picture = pictures.find(view.name);
    const Eigen::Quaterniond& q = view.cam_from_world.rotation;
    photos.push_back(
        {{"name", view.name},
         {"holdout", holdout},
         {"width", view.camera.width},
         {"height", view.camera.height},
         {"fx", view.camera.fx},
         {"fy", view.camera.fy},
         {"cx", view.camera.cx},
         {"cy", view.camera.cy},
         {"rotation", {q.w(), q.x(), q.y(), q.z()}},
         {"translation", Vector(view.cam_from_world.translation)},
         {"image", picture == pictures.end() ? "" : picture->second}});
  };
  for (const View& view : scene.train) add(view, false);
  for (const View& view : scene.holdout) add(view, true);
  std::stable_sort(
      photos.begin(), photos.end(), [](const json& a, const json& b) {
        return a["name"].get_ref<const std::string&>() <
               b["name"].get_ref<const std::string&>();
      });
  return photos;
}

json ObjectsJson(const std::vector<semantics::Instance>& instances,
                 const splat::ModelFrame& frame) {
  const Sim3d frame_from_world = frame.FrameFromWorld();
  json objects = json::array();
  for (const semantics::Instance& instance : instances) {
    json rotation = json::array();
    for (int row = 0; row < 3; ++row) {
      rotation.push_back(Vector(instance.obb.rotation.row(row).transpose()));
    }
    objects.push_back(
        {{"id", instance.id},
         {"words", instance.words},
         {"score", instance.score},
         {"background", instance.background},
         {"num_gaussians", instance.num_gaussians},
         {"color", semantics::PaletteColor(instance.id - 1)},
         {"obb",
          {{"center", Vector(frame_from_world * instance.obb.centre)},
           {"size", Vector(instance.obb.size / frame.unit)},
           {"rotation", std::move(rotation)}}}});
  }
  return objects;
}

json LevelsJson(const ViewerLevels& levels) {
  const auto intervals = [](const std::vector<PartInterval>& list) {
    json result = json::array();
    for (const PartInterval& interval : list) {
      result.push_back({interval.begin, interval.end});
    }
    return result;
  };
  json result = json::object();
  for (size_t label = 0; label < levels.of_label.size(); ++label) {
    const InstanceLevels& of = levels.of_label[label];
    if (of.wider.empty() && of.narrower.empty()) continue;
    result[std::to_string(label + 1)] = {{"wider", intervals(of.wider)},
                                         {"narrower", intervals(of.narrower)}};
  }
  return result;
}

// The largest coordinate of a Gaussian.
double DistanceOf(const splat::GaussianModel& model, size_t g) {
  double distance = 0;
  for (size_t k = 3 * g; k < 3 * g + 3; ++k) {
    distance = std::max(distance, std::abs(double{model.means[k]}));
  }
  return distance;
}

// Brings nearer what is too far away, or far away and too large for the format,
// and makes it smaller by the same factor. From the cameras, which are near the
// origin, it looks the same. All that is far away moves by one rule, by which a
// distance becomes a power of itself, so that along a line of sight what hides
// another thing still does.
void BringNearer(splat::GaussianModel* model) {
  double power = 1;
  for (size_t g = 0; g < model->size(); ++g) {
    const double distance = DistanceOf(*model, g);
    if (distance <= kFar) continue;
    const float* const log_scales = model->log_scales.data() + 3 * g;
    const double log_scale = *std::max_element(log_scales, log_scales + 3);
    const double fits = std::min(
        double{kFarthest},
        distance * std::exp(std::min(0.0, splat::kMaxSpzLogScale - log_scale)));
    // What is too large even much nearer loses its size, or it would take all
    // that is far away to one distance.
    if (fits < 2 * kFar) continue;
    power = std::min(power, std::log(fits / kFar) / std::log(distance / kFar));
  }
  if (power >= 1) return;
  for (size_t g = 0; g < model->size(); ++g) {
    const double distance = DistanceOf(*model, g);
    if (distance <= kFar) continue;
    const double nearer =
        std::min(double{kFarthest}, kFar * std::pow(distance / kFar, power));
    for (size_t k = 3 * g; k < 3 * g + 3; ++k) {
      model->means[k] *= static_cast<float>(nearer / distance);
      model->log_scales[k] += static_cast<float>(std::log(nearer / distance));
    }
  }
}

// Gaussians by the area that they cover, the largest first, in parts. Within a
// part they are in the model's order, in which neighbours in space are near
// each other: that is what gzip makes use of.
std::vector<std::vector<uint32_t>> DivideIntoParts(
    const splat::GaussianModel& model, int part_size) {
  std::vector<float> areas(model.size());
  for (size_t g = 0; g < areas.size(); ++g) {
    std::array<float, 3> s = {model.log_scales[3 * g],
                              model.log_scales[3 * g + 1],
                              model.log_scales[3 * g + 2]};
    std::sort(s.begin(), s.end());
    areas[g] =
        std::exp(s[1] + s[2]) / (1.0f + std::exp(-model.opacity_logits[g]));
  }
  std::vector<uint32_t> order(model.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return areas[a] > areas[b];
  });
  std::vector<std::vector<uint32_t>> parts;
  for (size_t first = 0; first < order.size();) {
    const size_t size = first == 0 ? (part_size + 2) / 3 : part_size;
    const size_t end = std::min(order.size(), first + size);
    parts.emplace_back(order.begin() + first, order.begin() + end);
    std::sort(parts.back().begin(), parts.back().end());
    first = end;
  }
  return parts;
}

std::string LabelBytes(const Objects& objects,
                       std::span<const uint32_t> gaussians) {
  std::string bytes;
  const auto put = [&bytes](int32_t value) {
    bytes.push_back(static_cast<char>(value & 0xff));
    bytes.push_back(static_cast<char>(value >> 8 & 0xff));
  };
  for (const uint32_t g : gaussians) {
    const int32_t id = objects.labels[g] + 1;
    put(id <= 65535 ? id : 0);
    const std::vector<int32_t>& ranks = objects.levels.rank_of_gaussian;
    put(ranks.empty() || ranks[g] < 0 ? kNoPart : ranks[g]);
  }
  return bytes;
}

// All parts with this degree of spherical harmonics, and their bytes.
// kInterrupted when cancelled.
StatusOr<int64_t> WriteSplats(const splat::GaussianModel& model,
                              std::span<const std::vector<uint32_t>> parts,
                              int sh_degree,
                              const CancellationToken* cancellation,
                              std::vector<ViewerScene::Part>* result) {
  int64_t bytes = 0;
  for (size_t p = 0; p < parts.size(); ++p) {
    if (IsCancelled(cancellation)) {
      return InterruptedError("stopped while making the scene of the page");
    }
    FREEGS_ASSIGN_OR_RETURN(
        (*result)[p].splats,
        splat::SerializeSpz(model.Selected(parts[p]),
                            {.sh_degree = sh_degree, .flip_axes = false}));
    bytes += std::ssize((*result)[p].splats);
  }
  return bytes;
}

}  // namespace

Status ViewerSceneOptions::Check() const {
  if (part_size < 1) {
    return InvalidArgumentError("a part has at least one Gaussian");
  }
  return Status();
}

StatusOr<ViewerScene> MakeViewerScene(const fs::path& workspace,
                                      const ViewerSceneOptions& options) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  FREEGS_ASSIGN_OR_RETURN(WorkspaceScene scene, ReadWorkspaceScene(workspace));
  BringNearer(&scene.model);
  const splat::GaussianModel& model = scene.model;
  FREEGS_ASSIGN_OR_RETURN(const Objects objects,
                          ReadObjects(workspace, model.size()));

  const std::vector<std::vector<uint32_t>> parts =
      DivideIntoParts(model, options.part_size);
  ViewerScene result;
  result.parts.resize(parts.size());
  json counts = json::array();
  for (size_t p = 0; p < parts.size(); ++p) {
    result.parts[p].labels = LabelBytes(objects, parts[p]);
    counts.push_back({{"num_gaussians", parts[p].size()}});
  }
  int degree = model.sh_degree;
  for (;; --degree) {
    FREEGS_ASSIGN_OR_RETURN(
        const int64_t bytes,
        WriteSplats(model, parts, degree, options.cancellation, &result.parts));
    if (degree == 0 || !options.max_bytes || bytes <= *options.max_bytes) break;
  }

  std::vector<View> views = scene.train;
  views.insert(views.end(), scene.holdout.begin(), scene.holdout.end());
  const Eigen::Vector3d up =
      semantics::VerticalOfBoxes(views, objects.instances)
          .value_or(-Eigen::Vector3d::UnitY());
  std::error_code error;
  const std::string name =
      fs::weakly_canonical(workspace, error).filename().string();
  const auto& background = scene.render.background;
  result.description = {
      {"format", "freegs-viewer-scene"},
      {"version", 1},
      {"title", ValidUtf8(name)},
      {"origin", Vector(scene.frame.origin)},
      {"unit", scene.frame.unit},
      {"up", Vector(up)},
      // The frame is chosen so that the middle of the scene is at its origin,
      // and cameras are typically so far from what they see.
      {"focus", Vector(Eigen::Vector3d::Zero())},
      {"radius", splat::kTypicalDepth},
      {"background", {background[0], background[1], background[2]}},
      {"antialiased", model.antialiased},
      {"num_gaussians", model.size()},
      {"sh_degree", degree},
      {"photos", PhotosJson(scene, options.pictures)},
      {"objects", ObjectsJson(objects.instances, scene.frame)},
      {"levels", LevelsJson(objects.levels)},
      {"parts", std::move(counts)}};
  return result;
}

std::string ViewerSceneScript(const ViewerScene& scene) {
  json parts = json::array();
  for (const ViewerScene::Part& part : scene.parts) {
    parts.push_back({{"splats", EncodeBase64(part.splats)},
                     {"labels", EncodeBase64(part.labels)}});
  }
  return "globalThis.freegsScene = " +
         JsonText(
             {{"description", scene.description}, {"parts", std::move(parts)}},
             -1);
}

}  // namespace freegs::stages
