// SPDX-License-Identifier: BSD-3-Clause
// COLMAP's binary model files.

#include "sfm/scene/model_io_binary.h"

#include <bit>
#include <cmath>
#include <cstring>

namespace freegs::sfm {
namespace {

static_assert(std::endian::native == std::endian::little,
              "COLMAP's binary files are read on little-endian machines only");

// Takes values off the front of a buffer; false once it has run out.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  template <typename T>
  bool Read(T* value) {
    if (bytes_.size() < sizeof(T)) return false;
    std::memcpy(value, bytes_.data(), sizeof(T));
    bytes_.remove_prefix(sizeof(T));
    return true;
  }

  // A zero-terminated text.
  bool ReadText(std::string* text) {
    const size_t end = bytes_.find('\0');
    if (end == std::string_view::npos) return false;
    text->assign(bytes_.substr(0, end));
    bytes_.remove_prefix(end + 1);
    return true;
  }

  // A count of items of at least min_bytes each, all of which must still fit.
  bool ReadCount(size_t min_bytes, uint64_t* count) {
    return Read(count) && *count <= bytes_.size() / min_bytes;
  }

  bool empty() const { return bytes_.empty(); }
  size_t remaining() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
};

template <typename T>
void Append(const T& value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(T));
}

Status Truncated(const std::string& what) {
  return BadInputError("ends early or promises too much, in " + what);
}

Status TrailingBytes(size_t count) {
  return BadInputError("has " + std::to_string(count) +
                       " bytes after its last item");
}

}  // namespace

Status ParseCamerasBinary(std::string_view bytes,
                          std::vector<Camera>* cameras) {
  Reader reader(bytes);
  uint64_t count = 0;
  if (!reader.ReadCount(24, &count)) return Truncated("the number of cameras");
  cameras->reserve(count);
  for (uint64_t i = 0; i < count; ++i) {
    Camera camera;
    int32_t model = 0;
    if (!reader.Read(&camera.id) || !reader.Read(&model) ||
        !reader.Read(&camera.width) || !reader.Read(&camera.height)) {
      return Truncated("camera number " + std::to_string(i));
    }
    const CameraModelInfo* info = FindCameraModel(model);
    if (info == nullptr) {
      return BadInputError("camera " + std::to_string(camera.id) +
                           " has model number " + std::to_string(model) +
                           ", which is unknown");
    }
    camera.model = info->model;
    camera.params.resize(info->num_params);
    for (double& param : camera.params) {
      if (!reader.Read(&param)) {
        return Truncated("camera " + std::to_string(camera.id));
      }
    }
    cameras->push_back(std::move(camera));
  }
  return reader.empty() ? Status() : TrailingBytes(reader.remaining());
}

Status ParseImagesBinary(std::string_view bytes,
                         std::vector<PosedImage>* images) {
  Reader reader(bytes);
  uint64_t count = 0;
  if (!reader.ReadCount(73, &count)) return Truncated("the number of images");
  images->reserve(count);
  for (uint64_t i = 0; i < count; ++i) {
    PosedImage image;
    Eigen::Quaterniond& q = image.cam_from_world.rotation;
    Eigen::Vector3d& t = image.cam_from_world.translation;
    uint64_t num_points = 0;
    if (!reader.Read(&image.id) || !reader.Read(&q.w()) ||
        !reader.Read(&q.x()) || !reader.Read(&q.y()) || !reader.Read(&q.z()) ||
        !reader.Read(&t.x()) || !reader.Read(&t.y()) || !reader.Read(&t.z()) ||
        !reader.Read(&image.camera_id) || !reader.ReadText(&image.name) ||
        !reader.ReadCount(24, &num_points)) {
      return Truncated("image number " + std::to_string(i));
    }
    // Left alone when already a unit, so that writing gives the same bytes.
    if (std::abs(q.squaredNorm() - 1) > 1e-12) q.normalize();
    image.points2d.resize(num_points);
    for (Point2D& point : image.points2d) {
      // Cannot fail: ReadCount made sure that they fit.
      reader.Read(&point.xy.x());
      reader.Read(&point.xy.y());
      reader.Read(&point.point3d_id);
    }
    images->push_back(std::move(image));
  }
  return reader.empty() ? Status() : TrailingBytes(reader.remaining());
}

Status ParsePointsBinary(std::string_view bytes, std::vector<Point3D>* points) {
  Reader reader(bytes);
  uint64_t count = 0;
  if (!reader.ReadCount(51, &count)) return Truncated("the number of points");
  points->reserve(count);
  for (uint64_t i = 0; i < count; ++i) {
    Point3D point;
    uint64_t track_length = 0;
    if (!reader.Read(&point.id) || !reader.Read(&point.xyz.x()) ||
        !reader.Read(&point.xyz.y()) || !reader.Read(&point.xyz.z()) ||
        !reader.Read(&point.rgb) || !reader.Read(&point.error) ||
        !reader.ReadCount(8, &track_length)) {
      return Truncated("point number " + std::to_string(i));
    }
    point.track.resize(track_length);
    for (TrackElement& element : point.track) {
      reader.Read(&element.image_id);
      reader.Read(&element.point2d_index);
    }
    points->push_back(std::move(point));
  }
  return reader.empty() ? Status() : TrailingBytes(reader.remaining());
}

std::string CamerasToBinary(const std::vector<Camera>& cameras) {
  std::string bytes;
  Append<uint64_t>(cameras.size(), &bytes);
  for (const Camera& camera : cameras) {
    Append(camera.id, &bytes);
    Append(static_cast<int32_t>(camera.model), &bytes);
    Append(camera.width, &bytes);
    Append(camera.height, &bytes);
    for (const double param : camera.params) Append(param, &bytes);
  }
  return bytes;
}

std::string ImagesToBinary(const std::vector<PosedImage>& images) {
  std::string bytes;
  Append<uint64_t>(images.size(), &bytes);
  for (const PosedImage& image : images) {
    const Eigen::Quaterniond& q = image.cam_from_world.rotation;
    const Eigen::Vector3d& t = image.cam_from_world.translation;
    Append(image.id, &bytes);
    for (const double v : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) {
      Append(v, &bytes);
    }
    Append(image.camera_id, &bytes);
    bytes.append(image.name.c_str(), image.name.size() + 1);
    Append<uint64_t>(image.points2d.size(), &bytes);
    for (const Point2D& point : image.points2d) {
      Append(point.xy.x(), &bytes);
      Append(point.xy.y(), &bytes);
      Append(point.point3d_id, &bytes);
    }
  }
  return bytes;
}

std::string PointsToBinary(const std::vector<Point3D>& points) {
  std::string bytes;
  Append<uint64_t>(points.size(), &bytes);
  for (const Point3D& point : points) {
    Append(point.id, &bytes);
    for (const double v : {point.xyz.x(), point.xyz.y(), point.xyz.z()}) {
      Append(v, &bytes);
    }
    Append(point.rgb, &bytes);
    Append(point.error, &bytes);
    Append<uint64_t>(point.track.size(), &bytes);
    for (const TrackElement& element : point.track) {
      Append(element.image_id, &bytes);
      Append(element.point2d_index, &bytes);
    }
  }
  return bytes;
}

}  // namespace freegs::sfm
