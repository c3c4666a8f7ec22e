// SPDX-License-Identifier: BSD-3-Clause

#include "stages/datasets/scannet.h"

#include <cstdlib>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "core/decompositions.h"
#include "core/io/files.h"
#include "core/io/json_fields.h"
#include "stages/datasets/mask_folders.h"
#include "stages/datasets/scannet_mesh.h"
#include "stages/datasets/scannet_objects.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxFileBytes = uint64_t{1} << 31;
constexpr uint64_t kMaxPoseBytes = 4096;

// The file whose name ends with one of the suffixes. Of several it is the one
// with the shortest name: SCAN.aggregation.json is preferred to
// SCAN_vh_clean.aggregation.json, which belongs to the fine mesh.
StatusOr<fs::path> FindBySuffix(const fs::path& folder,
                                const std::vector<std::string>& suffixes) {
  const std::vector<std::string> files = FilesIn(folder);
  for (const std::string& suffix : suffixes) {
    std::optional<std::string> found;
    for (const std::string& file : files) {
      if (file.ends_with(suffix) && (!found || file.size() < found->size())) {
        found = file;
      }
    }
    if (found) return folder / *found;
  }
  return BadInputError((folder / ("SCAN" + suffixes[0])).string() +
                       ": no such file; it belongs to the scan's download");
}

// Reads a pose; nothing for a frame whose pose was lost.
StatusOr<std::optional<Eigen::Matrix4d>> ReadPose(const fs::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string text,
                          ReadFile(path, kMaxPoseBytes));
  Eigen::Matrix4d world_from_cam;
  const char* rest = text.c_str();
  for (int k = 0; k < 16; ++k) {
    char* end = nullptr;
    // strtod also reads "-inf".
    world_from_cam(k / 4, k % 4) = std::strtod(rest, &end);
    if (end == rest) {
      return BadInputError(path.string() + ": must be 16 numbers");
    }
    rest = end;
  }
  if (!world_from_cam.allFinite()) return std::optional<Eigen::Matrix4d>();
  constexpr double kTolerance = 1e-2;
  FREEGS_RETURN_IF_ERROR(CheckRotation(
      world_from_cam.topLeftCorner<3, 3>(), path.string(), kTolerance));
  return std::optional(world_from_cam);
}

StatusOr<std::vector<View>> ReadFrames(const fs::path& folder,
                                       const Eigen::Matrix4d& alignment) {
  std::vector<View> views;
  for (const std::string& file : FilesIn(folder)) {
    if (!file.ends_with(".txt")) continue;
    FREEGS_ASSIGN_OR_RETURN(const auto pose, ReadPose(folder / file));
    if (!pose) continue;
    const Eigen::Matrix4d world_from_cam = alignment * *pose;
    const Eigen::Matrix3d rotation = world_from_cam.topLeftCorner<3, 3>();
    View view;
    view.name = fs::path(file).replace_extension(".jpg").string();
    view.cam_from_world =
        Inverse(Rigid3d{Eigen::Quaterniond(NearestRotation(rotation)),
                        world_from_cam.topRightCorner<3, 1>()});
    views.push_back(std::move(view));
  }
  if (views.empty()) {
    return BadInputError(folder.string() +
                         ": no frame with a pose (N.txt); export them with "
                         "ScanNet's SensReader");
  }
  return views;
}

template <typename Parse>
auto ParseFile(const fs::path& path, Parse parse)
    -> decltype(parse(std::string_view(), std::string())) {
  FREEGS_ASSIGN_OR_RETURN(const std::string text,
                          ReadFile(path, kMaxFileBytes));
  return parse(std::string_view(text), path.string());
}

// The scan's mesh, and the pieces of it that are objects.
struct Annotation {
  std::string scan_name;
  ScannetMesh mesh;
  ScannetPieces pieces;
};

StatusOr<Annotation> ReadAnnotation(const fs::path& scan) {
  const std::string kGroups = ".aggregation.json";
  const std::string kLabels = "_vh_clean_2.labels.ply";
  Annotation annotation;
  const StatusOr<fs::path> groups = FindBySuffix(scan, {kGroups});
  if (!groups.ok()) {
    const StatusOr<fs::path> labels = FindBySuffix(scan, {kLabels});
    if (!labels.ok()) return groups.status();
    const std::string file = labels->filename().string();
    annotation.scan_name = file.substr(0, file.size() - kLabels.size());
    FREEGS_ASSIGN_OR_RETURN(annotation.mesh,
                            ParseFile(*labels, ParseScannetMesh));
    StatusOr<ScannetPieces> pieces = FindPieces(annotation.mesh);
    if (!pieces.ok()) {
      return BadInputError(labels->string() + ": " + pieces.status().message());
    }
    annotation.pieces = *std::move(pieces);
    return annotation;
  }
  const std::string file = groups->filename().string();
  annotation.scan_name = file.substr(0, file.size() - kGroups.size());
  FREEGS_ASSIGN_OR_RETURN(
      const fs::path segments,
      FindBySuffix(scan, {"_vh_clean_2.0.010000.segs.json", "_2.segs.json"}));
  FREEGS_ASSIGN_OR_RETURN(const fs::path mesh,
                          FindBySuffix(scan, {"_vh_clean_2.ply", kLabels}));
  FREEGS_ASSIGN_OR_RETURN(annotation.pieces.groups,
                          ParseFile(*groups, ParseScannetGroups));
  FREEGS_ASSIGN_OR_RETURN(annotation.pieces.segments,
                          ParseFile(segments, ParseScannetSegments));
  FREEGS_ASSIGN_OR_RETURN(annotation.mesh, ParseFile(mesh, ParseScannetMesh));
  return annotation;
}

}  // namespace

StatusOr<GroundTruth> ReadScannet(const fs::path& scan) {
  FREEGS_ASSIGN_OR_RETURN(const Annotation annotation, ReadAnnotation(scan));
  Eigen::Matrix4d alignment = Eigen::Matrix4d::Identity();
  const fs::path facts = scan / (annotation.scan_name + ".txt");
  std::error_code error;
  if (fs::exists(facts, error)) {
    FREEGS_ASSIGN_OR_RETURN(alignment, ParseFile(facts, ParseScannetAlignment));
  }
  GroundTruth truth;
  truth.folder = scan;
  StatusOr<std::vector<TrueObject>> objects =
      ScannetBoxes(annotation.mesh.vertices,
                   annotation.pieces.segments,
                   annotation.pieces.groups,
                   alignment);
  if (!objects.ok()) {
    return BadInputError(scan.string() + ": the mesh and the segments of " +
                         annotation.scan_name + " do not belong together: " +
                         objects.status().message());
  }
  truth.objects = *std::move(objects);
  FREEGS_ASSIGN_OR_RETURN(truth.cameras.train,
                          ReadFrames(scan / "pose", alignment));
  return truth;
}

}  // namespace freegs::stages
