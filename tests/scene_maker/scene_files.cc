// SPDX-License-Identifier: BSD-3-Clause

#include "tests/scene_maker/scene_files.h"

#include <algorithm>
#include <cmath>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/json_text.h"
#include "tests/scene_maker/ray_caster.h"

namespace freegs::scene_maker {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kMinMaskPixels = 30;

using Eigen::Vector3d;

json VectorJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

json MatrixJson(const Eigen::Matrix3d& m) {
  json rows = json::array();
  for (int r = 0; r < 3; ++r) rows.push_back(VectorJson(m.row(r).transpose()));
  return rows;
}

json PosesJson(const std::vector<View>& views) {
  json poses = json::object();
  for (const View& view : views) {
    const Eigen::Matrix<double, 3, 4> matrix = view.cam_from_world.Matrix3x4();
    json rows = json::array();
    for (int r = 0; r < 3; ++r) {
      rows.push_back(json::array(
          {matrix(r, 0), matrix(r, 1), matrix(r, 2), matrix(r, 3)}));
    }
    rows.push_back(json::array({0.0, 0.0, 0.0, 1.0}));
    poses[view.name] = rows;
  }
  return poses;
}

json CamerasJson(const Scene& scene) {
  const Pinhole& camera = scene.train.front().camera;
  return {{"convention",
           "world_to_camera is 4x4 row-major, OpenCV/COLMAP axes (x right, y "
           "down, z forward); pixel centres at +0.5; world in metres, z up; no "
           "lens distortion"},
          {"intrinsics",
           {{"model", "PINHOLE"},
            {"w", camera.width},
            {"h", camera.height},
            {"fx", camera.fx},
            {"fy", camera.fy},
            {"cx", camera.cx},
            {"cy", camera.cy}}},
          {"train", PosesJson(scene.train)},
          {"test", PosesJson(scene.test)}};
}

// The training cameras as nerfstudio writes them, for --sfm.import.
json TransformsJson(const Scene& scene) {
  const Pinhole& camera = scene.train.front().camera;
  json frames = json::array();
  for (const View& view : scene.train) {
    // Camera to world, with y up and z backward.
    const Eigen::Matrix3d rotation =
        view.cam_from_world.rotation.conjugate().toRotationMatrix() *
        Vector3d(1, -1, -1).asDiagonal();
    const Vector3d centre = CameraCentre(view.cam_from_world);
    json rows = json::array();
    for (int r = 0; r < 3; ++r) {
      rows.push_back(json::array(
          {rotation(r, 0), rotation(r, 1), rotation(r, 2), centre[r]}));
    }
    rows.push_back(json::array({0.0, 0.0, 0.0, 1.0}));
    frames.push_back(
        {{"file_path", "images/" + view.name}, {"transform_matrix", rows}});
  }
  return {{"w", camera.width},
          {"h", camera.height},
          {"fl_x", camera.fx},
          {"fl_y", camera.fy},
          {"cx", camera.cx},
          {"cy", camera.cy},
          {"frames", frames}};
}

// Pixels of each object, by id, in each view.
using PixelCounts = std::vector<std::vector<int>>;

json ObjectsJson(const Scene& scene,
                 const PixelCounts& train,
                 const PixelCounts& test) {
  json objects = json::array();
  for (const SceneObject& object : scene.objects) {
    json visible = json::object();
    for (size_t i = 0; i < scene.test.size(); ++i) {
      const int count = test[i][static_cast<size_t>(object.id)];
      if (count > 0) visible[fs::path(scene.test[i].name).stem()] = count;
    }
    int train_views = 0;
    for (const std::vector<int>& counts : train) {
      if (counts[static_cast<size_t>(object.id)] >= kMinMaskPixels) {
        ++train_views;
      }
    }
    objects.push_back({{"id", object.id},
                       {"label", object.label},
                       {"class", object.kind},
                       {"aabb",
                        {{"min", VectorJson(object.aabb.min)},
                         {"max", VectorJson(object.aabb.max)}}},
                       {"obb",
                        {{"center", VectorJson(object.obb.centre)},
                         {"size", VectorJson(object.obb.size)},
                         {"rotation", MatrixJson(object.obb.rotation)}}},
                       {"centroid", VectorJson(object.centroid)},
                       {"visible_pixels_test", visible},
                       {"train_views_visible", train_views}});
  }
  json touching = json::array();
  for (const auto& [a, b] : scene.touching)
    touching.push_back(json::array({a, b}));
  return {{"units", "metres"},
          {"up", "+z"},
          {"objects", objects},
          {"background", kBackgroundClasses},
          {"touching_pairs", touching},
          {"obb_note",
           "rotation: 3x3, columns are the box axes in the world; world = "
           "center + rotation @ (size * u), u in [-0.5, 0.5]"}};
}

std::string What(const Scene& scene) {
  switch (scene.options.subject) {
    case Subject::kChairs:
      return "Two equal chairs in a room";
    case Subject::kTiles:
      return "A wall of equal tiles in a room";
    case Subject::kStudio:
      return std::to_string(scene.objects.size()) + " objects on a round board";
    case Subject::kFurniture:
      return std::to_string(scene.objects.size()) +
             " pieces of furniture in a room";
    case Subject::kClutter:
    case Subject::kTable:
      break;
  }
  return std::to_string(scene.objects.size()) +
         " objects on a round table in a room";
}

std::string Readme(const Scene& scene) {
  const SceneMakerOptions& options = scene.options;
  std::string text =
      "# A made-up scene\n\n" + What(scene) +
      ", drawn by freegs_make_scene (seed " + std::to_string(options.seed) +
      ").\n\n" + "* `images/` " + std::to_string(options.views) +
      " training photos, " + std::to_string(options.width) + "x" +
      std::to_string(options.height) +
      ", JPEG, constant exposure, no EXIF, no distortion\n"
      "* `test/images/` " +
      std::to_string(options.test_views) +
      " photos at other poses (PNG); `test/masks/<view>/<label>.png` 0/255 "
      "mask of each object with >= 30 visible pixels; "
      "`test/masks_background/<view>/{table,floor,wall}.png` likewise\n"
      "* `gt/instance/<view>.png` 8-bit object id per pixel, 0 = background; "
      "one ray through each pixel centre\n"
      "* `gt/cameras.json` pinhole intrinsics; world-to-camera 4x4, OpenCV "
      "axes\n"
      "* `gt/objects.json` id, label, class, world AABB and oriented box, "
      "metres, z up; boxes are of the whole object\n"
      "* `gt/depth/<test view>.npz` key `depth`: z-depth in metres, float16\n\n"
      "Objects (id: label):\n";
  for (const SceneObject& object : scene.objects) {
    text += "* " + std::to_string(object.id) + ": " + object.label + "\n";
  }
  return text;
}

ImageU8 Narrow(const ImageU16& ids) {
  ImageU8 narrow(ids.width(), ids.height(), 1);
  std::transform(
      ids.data(), ids.data() + ids.size(), narrow.data(), [](uint16_t v) {
        return static_cast<uint8_t>(v);
      });
  return narrow;
}

ImageU8 MaskOf(const ImageU16& labels, int label) {
  ImageU8 mask(labels.width(), labels.height(), 1);
  std::transform(labels.data(),
                 labels.data() + labels.size(),
                 mask.data(),
                 [label](uint16_t v) {
                   return static_cast<uint8_t>(v == label ? 255 : 0);
                 });
  return mask;
}

std::vector<int> CountPixels(const ImageU16& labels, size_t num_labels) {
  std::vector<int> counts(num_labels, 0);
  for (size_t i = 0; i < labels.size(); ++i) ++counts[labels.data()[i]];
  return counts;
}

Status WriteTestTruth(const Scene& scene,
                      const Photo& photo,
                      const std::vector<int>& counts,
                      const fs::path& folder,
                      const std::string& stem) {
  const fs::path masks = folder / "test/masks" / stem;
  const fs::path background = folder / "test/masks_background" / stem;
  FREEGS_RETURN_IF_ERROR(CreateFolders(masks));
  FREEGS_RETURN_IF_ERROR(CreateFolders(background));
  for (const SceneObject& object : scene.objects) {
    if (counts[static_cast<size_t>(object.id)] < kMinMaskPixels) continue;
    FREEGS_RETURN_IF_ERROR(WriteImage(masks / (object.label + ".png"),
                                      MaskOf(photo.instances, object.id)));
  }
  for (size_t i = 0; i < kBackgroundClasses.size(); ++i) {
    FREEGS_RETURN_IF_ERROR(
        WriteImage(background / (std::string(kBackgroundClasses[i]) + ".png"),
                   MaskOf(photo.background, static_cast<int>(i) + 1)));
  }
  return WriteFileAtomic(folder / "gt/depth" / (stem + ".npz"),
                         EncodeNpzFloat16("depth", photo.depth));
}

}  // namespace

Status WriteScene(const Scene& scene,
                  const fs::path& folder,
                  ThreadPool& pool,
                  const std::function<void(int, int)>& progress) {
  // Photographs of another scene would be mixed with these.
  for (const char* name : {"images", "README.md"}) {
    std::error_code error;
    if (fs::exists(folder / name, error)) {
      return BadInputError((folder / name).string() +
                           ": is there already; give an empty folder");
    }
  }
  for (const char* name :
       {"images", "test/images", "gt/instance", "gt/depth"}) {
    FREEGS_RETURN_IF_ERROR(CreateFolders(folder / name));
  }
  const bool with_surfaces = scene.options.subject == Subject::kClutter ||
                             scene.options.subject == Subject::kFurniture;
  if (with_surfaces) {
    FREEGS_RETURN_IF_ERROR(CreateFolders(folder / "gt/surfaces"));
  }
  const size_t num_labels = scene.objects.size() + 1;
  const int total = static_cast<int>(scene.train.size() + scene.test.size());
  int done = 0;
  PixelCounts train;
  PixelCounts test;
  for (const bool is_test : {false, true}) {
    const fs::path photos = folder / (is_test ? "test/images" : "images");
    for (const View& view : is_test ? scene.test : scene.train) {
      const Photo photo = CastRays(scene, view, pool);
      const std::vector<int> counts = CountPixels(photo.instances, num_labels);
      const std::string stem = fs::path(view.name).stem();
      FREEGS_RETURN_IF_ERROR(WriteImage(photos / view.name, photo.color));
      FREEGS_RETURN_IF_ERROR(WriteImage(
          folder / "gt/instance" / (stem + ".png"), Narrow(photo.instances)));
      if (with_surfaces) {
        FREEGS_RETURN_IF_ERROR(WriteImage(
            folder / "gt/surfaces" / (stem + ".png"), Narrow(photo.surfaces)));
      }
      if (is_test) {
        FREEGS_RETURN_IF_ERROR(
            WriteTestTruth(scene, photo, counts, folder, stem));
      }
      (is_test ? test : train).push_back(counts);
      if (progress) progress(++done, total);
    }
  }
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(folder / "gt/cameras.json",
                                         JsonText(CamerasJson(scene), 1)));
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(folder / "gt/transforms.json",
                                         JsonText(TransformsJson(scene), 1)));
  FREEGS_RETURN_IF_ERROR(
      WriteFileAtomic(folder / "gt/objects.json",
                      JsonText(ObjectsJson(scene, train, test), 1)));
  return WriteFileAtomic(folder / "README.md", Readme(scene));
}

}  // namespace freegs::scene_maker
