// SPDX-License-Identifier: BSD-3-Clause
// Parses transforms.json.

#include "sfm/import/transforms_json.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <nlohmann/json.hpp>

#include "core/decompositions.h"
#include "core/io/json_fields.h"
#include "core/number_text.h"
#include "sfm/import/resize.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {
namespace {

using nlohmann::json;

// If `object` gives a focal length or a field of view, overwrites all of them:
// those of before belong to another lens. One axis alone stands for both (see
// MakeCamera).
Status ReadFieldOfView(const json& object, TransformsIntrinsics* result) {
  double fx = 0, fy = 0, angle_x = 0, angle_y = 0, fov_x = 0, fov_y = 0;
  const std::pair<const char*, double*> fields[] = {
      {"fl_x", &fx},
      {"fl_y", &fy},
      {"camera_angle_x", &angle_x},
      {"camera_angle_y", &angle_y},
      {"x_fov", &fov_x},
      {"y_fov", &fov_y},
  };
  bool any = false;
  for (const auto& [key, value] : fields) {
    const json* field = FindField(object, key);
    if (field == nullptr || field->is_null()) continue;
    FREEGS_ASSIGN_OR_RETURN(*value, ReadNumber(field, key));
    any = any || *value != 0;
  }
  if (!any) return {};
  // instant-ngp writes and reads these two in degrees.
  constexpr double kRadians = std::numbers::pi / 180;
  result->fx = fx;
  result->fy = fy;
  result->angle_x = fov_x != 0 ? fov_x * kRadians : angle_x;
  result->angle_y = fov_y != 0 ? fov_y * kRadians : angle_y;
  return {};
}

// Overwrites the numbers that `object` (the file or one frame) gives.
Status ReadIntrinsics(const json& object, TransformsIntrinsics* result) {
  const std::pair<const char*, double*> fields[] = {
      {"w", &result->width},
      {"h", &result->height},
      {"k1", &result->k1},
      {"k2", &result->k2},
      {"k3", &result->k3},
      {"k4", &result->k4},
      {"k5", &result->k5},
      {"k6", &result->k6},
      {"p1", &result->p1},
      {"p2", &result->p2},
  };
  for (const auto& [key, value] : fields) {
    const json* field = FindField(object, key);
    if (field == nullptr || field->is_null()) continue;
    FREEGS_ASSIGN_OR_RETURN(*value, ReadNumber(field, key));
  }
  FREEGS_RETURN_IF_ERROR(ReadFieldOfView(object, result));
  const std::pair<const char*, double> lengths[] = {{"w", result->width},
                                                    {"h", result->height},
                                                    {"fl_x", result->fx},
                                                    {"fl_y", result->fy}};
  for (const auto& [key, value] : lengths) {
    if (value < 0) {
      return BadInputError("\"" + std::string(key) + "\" is negative");
    }
  }
  const std::pair<const char*, std::optional<double>*> centre[] = {
      {"cx", &result->cx},
      {"cy", &result->cy},
  };
  for (const auto& [key, value] : centre) {
    const json* field = FindField(object, key);
    if (field == nullptr || field->is_null()) continue;
    FREEGS_ASSIGN_OR_RETURN(*value, ReadNumber(field, key));
  }
  return {};
}

// Overwrites the kind of camera, if `object` gives it. Where it has both
// "is_fisheye" and "camera_model", the second one counts.
Status ReadKind(const json& object, TransformsIntrinsics* result) {
  const json* const fisheye = FindField(object, "is_fisheye");
  if (fisheye != nullptr && !fisheye->is_null()) {
    if (!fisheye->is_boolean() && !fisheye->is_number_integer()) {
      return BadInputError("\"is_fisheye\" is neither true nor false");
    }
    result->fisheye = fisheye->is_boolean() ? fisheye->get<bool>()
                                            : fisheye->get<int64_t>() != 0;
  }
  const json* const model = FindField(object, "camera_model");
  if (model != nullptr && !model->is_null()) {
    const std::string name =
        model->is_string() ? model->get<std::string>() : "";
    const std::set<std::string> perspective = {"OPENCV",
                                               "PINHOLE",
                                               "SIMPLE_PINHOLE",
                                               "SIMPLE_RADIAL",
                                               "RADIAL",
                                               "FULL_OPENCV",
                                               "PERSPECTIVE"};
    result->fisheye = name == "OPENCV_FISHEYE";
    result->full_opencv = name == "FULL_OPENCV";
    if (!result->fisheye && !perspective.contains(name)) {
      return BadInputError("\"camera_model\" is '" + name.substr(0, 64) +
                           "'; only perspective and OPENCV_FISHEYE cameras "
                           "are supported");
    }
  }
  return {};
}

Status ReadPose(const json& frame, Rigid3d* cam_from_world) {
  constexpr char kKey[] = "transform_matrix";
  const json* field = FindField(frame, kKey);
  const int rows =
      field != nullptr && field->is_array() && field->size() == 3 ? 3 : 4;
  Eigen::Matrix4d world_from_gl = Eigen::Matrix4d::Identity();
  FREEGS_ASSIGN_OR_RETURN(const Eigen::MatrixXd matrix,
                          ReadMatrix(field, rows, 4, kKey));
  world_from_gl.topRows(rows) = matrix;
  const Eigen::Matrix3d rotation = world_from_gl.topLeftCorner<3, 3>();
  constexpr double kRotationTolerance = 1e-2;  // Some tools write few digits.
  FREEGS_RETURN_IF_ERROR(CheckRotation(rotation, kKey, kRotationTolerance));
  const Eigen::RowVector4d last_row(0, 0, 0, 1);
  if ((world_from_gl.row(3) - last_row).cwiseAbs().maxCoeff() > 1e-6) {
    return BadInputError(
        "transform_matrix: the last row of a rotation and translation must be "
        "0 0 0 1");
  }
  if (world_from_gl.cwiseAbs().maxCoeff() > kMaxCoordinate) {
    return BadInputError(
        "transform_matrix: the camera is not at a finite "
        "distance, 1e12 at most");
  }
  const Eigen::DiagonalMatrix<double, 3> flip(1, -1, -1);
  Rigid3d world_from_cam;
  world_from_cam.rotation =
      Eigen::Quaterniond(NearestRotation(rotation * flip));
  world_from_cam.translation = world_from_gl.topRightCorner<3, 1>();
  *cam_from_world = Inverse(world_from_cam);
  return {};
}

// Appends the names of a list that may be missing or null.
Status ReadNames(const json& root,
                 const char* key,
                 std::vector<std::string>* names) {
  const json* list = FindField(root, key);
  if (list == nullptr || list->is_null()) return {};
  const Status fault =
      BadInputError("\"" + std::string(key) + "\" is not a list of names");
  if (!list->is_array()) return fault;
  for (const json& name : *list) {
    if (!name.is_string()) return fault;
    names->push_back(name.get<std::string>());
  }
  return {};
}

// The text of a field; empty when it is missing, or is no text.
std::string TextOf(const json& object, const char* key) {
  const json* field = FindField(object, key);
  if (field == nullptr || !field->is_string()) return "";
  return field->get<std::string>();
}

}  // namespace

StatusOr<TransformsFile> ParseTransforms(std::string_view text) {
  FREEGS_ASSIGN_OR_RETURN(const json root, ParseJsonObject(text));
  TransformsIntrinsics shared;
  FREEGS_RETURN_IF_ERROR(ReadKind(root, &shared));
  FREEGS_RETURN_IF_ERROR(ReadIntrinsics(root, &shared));
  const auto is_given = [&root](const char* key) {
    const json* const field = FindField(root, key);
    return field != nullptr && !field->is_null();
  };
  const bool has_kind = is_given("is_fisheye") || is_given("camera_model");
  const auto list = root.find("frames");
  if (list == root.end() || !list->is_array() || list->empty()) {
    return BadInputError("has no list \"frames\" with at least one frame");
  }
  TransformsFile file;
  FREEGS_RETURN_IF_ERROR(ReadNames(root, "test_filenames", &file.holdout));
  FREEGS_RETURN_IF_ERROR(ReadNames(root, "val_filenames", &file.holdout));
  file.points_file = TextOf(root, "ply_file_path");
  file.names_masks = !TextOf(root, "mask_path").empty();
  std::set<std::string> names;
  for (size_t i = 0; i < list->size(); ++i) {
    const json& entry = (*list)[i];
    std::string where = "frame " + std::to_string(i);
    if (!entry.is_object()) return BadInputError(where + " is not an object");
    TransformsFrame frame;
    const auto path = entry.find("file_path");
    if (path == entry.end() || !path->is_string() ||
        path->get_ref<const std::string&>().empty()) {
      return BadInputError(where + " has no \"file_path\"");
    }
    frame.file_path = path->get<std::string>();
    where += " ('" + frame.file_path.substr(0, 200) + "')";
    if (!names.insert(frame.file_path).second) {
      return BadInputError(where + " appears twice");
    }
    TransformsIntrinsics& own = frame.intrinsics;
    own = shared;
    FREEGS_RETURN_IF_ERROR(ReadKind(entry, &own).Annotated(where));
    if (has_kind && own.fisheye != shared.fisheye) {
      // Distortion of one kind means nothing to the other one. A file that does
      // not say its kind may give it for its frames.
      own.k1 = own.k2 = own.k3 = own.k4 = own.k5 = own.k6 = own.p1 = own.p2 = 0;
    }
    FREEGS_RETURN_IF_ERROR(ReadIntrinsics(entry, &own).Annotated(where));
    FREEGS_RETURN_IF_ERROR(
        ReadPose(entry, &frame.cam_from_world).Annotated(where));
    file.names_masks = file.names_masks || !TextOf(entry, "mask_path").empty();
    file.frames.push_back(std::move(frame));
  }
  return file;
}

StatusOr<Camera> MakeCamera(const TransformsIntrinsics& intrinsics,
                            int width,
                            int height) {
  const TransformsIntrinsics& in = intrinsics;
  double w = in.width > 0 ? in.width : width;
  double h = in.height > 0 ? in.height : height;
  // If the file gives one side only, the other one follows from it.
  if (in.width > 0 && in.height <= 0) h = w * height / width;
  if (in.height > 0 && in.width <= 0) w = h * width / height;
  const double sx = width / w;
  const double sy = height / h;
  if (!IsResized(w, h, width, height)) {
    return BadInputError(
        "the file gives an image size of " + FormatSignificant(w, 6) + " x " +
        FormatSignificant(h, 6) + " and the photo has " +
        std::to_string(width) + " x " + std::to_string(height) +
        " pixels, which is another shape");
  }
  const auto focal = [](double side, double angle) {
    return angle > 0 && angle < std::numbers::pi
               ? side / 2 / std::tan(angle / 2)
               : 0.0;
  };
  double fx = in.fx > 0 ? in.fx : focal(w, in.angle_x);
  double fy = in.fy > 0                                 ? in.fy
              : fx > 0 && in.fx <= 0 && in.angle_y <= 0 ? fx
                                                        : focal(h, in.angle_y);
  if (fy <= 0) fy = fx;
  if (fx <= 0) fx = fy;
  if (fx <= 0) {
    return BadInputError("gives neither \"fl_x\" nor \"camera_angle_x\"");
  }

  Camera camera;
  camera.width = static_cast<uint64_t>(width);
  camera.height = static_cast<uint64_t>(height);
  const double cx = in.cx.value_or(w / 2);
  const double cy = in.cy.value_or(h / 2);
  camera.params = {fx * sx, fy * sy, cx * sx, cy * sy};
  const auto append = [&](std::initializer_list<double> values) {
    camera.params.insert(camera.params.end(), values);
  };
  if (in.fisheye) {
    if (in.p1 != 0 || in.p2 != 0 || in.k5 != 0 || in.k6 != 0) {
      return BadInputError(
          "gives \"p1\", \"p2\", \"k5\" or \"k6\" for a fisheye, which is not "
          "supported");
    }
    camera.model = CameraModel::kOpenCvFisheye;
    append({in.k1, in.k2, in.k3, in.k4});
  } else if (!in.full_opencv && (in.k4 != 0 || in.k5 != 0 || in.k6 != 0)) {
    // Programs differ in what they mean: in nerfstudio's own model k4 belongs
    // to the eighth power of the radius, in OpenCV's it stands below a fraction
    // bar.
    return BadInputError(
        "gives \"k4\", \"k5\" or \"k6\" for a camera that is neither a fisheye "
        "nor FULL_OPENCV (\"camera_model\"), which is not supported");
  } else if (in.k3 != 0 || in.k4 != 0 || in.k5 != 0 || in.k6 != 0) {
    camera.model = CameraModel::kFullOpenCv;
    append({in.k1, in.k2, in.p1, in.p2, in.k3, in.k4, in.k5, in.k6});
  } else if (in.k1 != 0 || in.k2 != 0 || in.p1 != 0 || in.p2 != 0) {
    camera.model = CameraModel::kOpenCv;
    append({in.k1, in.k2, in.p1, in.p2});
  } else {
    camera.model = CameraModel::kPinhole;
  }
  FREEGS_RETURN_IF_ERROR(camera.Check());
  return camera;
}

}  // namespace freegs::sfm
