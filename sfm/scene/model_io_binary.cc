// SPDX-License-Identifier: BSD-3-Clause
// COLMAP's binary model files.

#include "sfm/scene/model_io_binary.h"

#include <cmath>
#include <cstdint>
#include <utility>

#include "core/io/byte_stream.h"

namespace freegs::sfm {
namespace {

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
  ByteReader reader(bytes);
  uint64_t count = 0;
  if (!reader.GetCount(24, &count)) return Truncated("the number of cameras");
  cameras->reserve(count);
  for (uint64_t i = 0; i < count; ++i) {
    Camera camera;
    int32_t model = 0;
    if (!reader.Get(&camera.id) || !reader.Get(&model) ||
        !reader.Get(&camera.width) || !reader.Get(&camera.height)) {
      return Truncated("camera number " + std::to_string(i));
    }
    const StatusOr<StoredCameraModel> stored = FindStoredCameraModel(model);
    if (!stored.ok()) {
      return stored.status().Annotated("camera " + std::to_string(camera.id));
    }
    camera.model = stored->model;
    camera.params.resize(stored->num_params);
    for (double& param : camera.params) {
      if (!reader.Get(&param)) {
        return Truncated("camera " + std::to_string(camera.id));
      }
    }
    CompleteParameters(*stored, &camera.params);
    cameras->push_back(std::move(camera));
  }
  return reader.at_end() ? Status() : TrailingBytes(reader.remaining());
}

Status ParseImagesBinary(std::string_view bytes,
                         std::vector<PosedImage>* images) {
  ByteReader reader(bytes);
  uint64_t count = 0;
  if (!reader.GetCount(73, &count)) return Truncated("the number of images");
  images->reserve(count);
  for (uint64_t i = 0; i < count; ++i) {
    PosedImage image;
    Eigen::Quaterniond& q = image.cam_from_world.rotation;
    Eigen::Vector3d& t = image.cam_from_world.translation;
    uint64_t num_points = 0;
    if (!reader.Get(&image.id) || !reader.Get(&q.w()) || !reader.Get(&q.x()) ||
        !reader.Get(&q.y()) || !reader.Get(&q.z()) || !reader.Get(&t.x()) ||
        !reader.Get(&t.y()) || !reader.Get(&t.z()) ||
        !reader.Get(&image.camera_id) ||
        !reader.GetTerminatedText(&image.name) ||
        !reader.GetCount(24, &num_points)) {
      return Truncated("image number " + std::to_string(i));
    }
    // Left alone when already a unit, so that writing gives the same bytes.
    if (std::abs(q.squaredNorm() - 1) > 1e-12) q.normalize();
    image.points2d.resize(num_points);
    for (Point2D& point : image.points2d) {
      // Cannot fail: GetCount made sure that they fit.
      reader.Get(&point.xy.x());
      reader.Get(&point.xy.y());
      reader.Get(&point.point3d_id);
    }
    images->push_back(std::move(image));
  }
  return reader.at_end() ? Status() : TrailingBytes(reader.remaining());
}

Status ParsePointsBinary(std::string_view bytes, std::vector<Point3D>* points) {
  ByteReader reader(bytes);
  uint64_t count = 0;
  if (!reader.GetCount(51, &count)) return Truncated("the number of points");
  points->reserve(count);
  for (uint64_t i = 0; i < count; ++i) {
    Point3D point;
    uint64_t track_length = 0;
    if (!reader.Get(&point.id) || !reader.Get(&point.xyz.x()) ||
        !reader.Get(&point.xyz.y()) || !reader.Get(&point.xyz.z()) ||
        !reader.GetArray(point.rgb.size(), point.rgb.data()) ||
        !reader.Get(&point.error) || !reader.GetCount(8, &track_length)) {
      return Truncated("point number " + std::to_string(i));
    }
    point.track.resize(track_length);
    for (TrackElement& element : point.track) {
      reader.Get(&element.image_id);
      reader.Get(&element.point2d_index);
    }
    points->push_back(std::move(point));
  }
  return reader.at_end() ? Status() : TrailingBytes(reader.remaining());
}

std::string CamerasToBinary(const std::vector<Camera>& cameras) {
  ByteWriter writer;
  writer.Put<uint64_t>(cameras.size());
  for (const Camera& camera : cameras) {
    writer.Put(camera.id);
    writer.Put(static_cast<int32_t>(camera.model));
    writer.Put(camera.width);
    writer.Put(camera.height);
    for (const double param : camera.params) writer.Put(param);
  }
  return std::move(writer).content();
}

std::string ImagesToBinary(const std::vector<PosedImage>& images) {
  ByteWriter writer;
  writer.Put<uint64_t>(images.size());
  for (const PosedImage& image : images) {
    const Eigen::Quaterniond& q = image.cam_from_world.rotation;
    const Eigen::Vector3d& t = image.cam_from_world.translation;
    writer.Put(image.id);
    for (const double v : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) {
      writer.Put(v);
    }
    writer.Put(image.camera_id);
    writer.PutTerminatedText(image.name);
    writer.Put<uint64_t>(image.points2d.size());
    for (const Point2D& point : image.points2d) {
      writer.Put(point.xy.x());
      writer.Put(point.xy.y());
      writer.Put(point.point3d_id);
    }
  }
  return std::move(writer).content();
}

std::string PointsToBinary(const std::vector<Point3D>& points) {
  ByteWriter writer;
  writer.Put<uint64_t>(points.size());
  for (const Point3D& point : points) {
    writer.Put(point.id);
    for (const double v : {point.xyz.x(), point.xyz.y(), point.xyz.z()}) {
      writer.Put(v);
    }
    writer.PutArray(point.rgb);
    writer.Put(point.error);
    writer.Put<uint64_t>(point.track.size());
    for (const TrackElement& element : point.track) {
      writer.Put(element.image_id);
      writer.Put(element.point2d_index);
    }
  }
  return std::move(writer).content();
}

}  // namespace freegs::sfm
