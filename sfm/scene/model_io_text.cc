// SPDX-License-Identifier: BSD-3-Clause
// COLMAP's text model files.

#include "sfm/scene/model_io_text.h"

#include <charconv>
#include <cmath>
#include <system_error>

#include "core/text.h"

namespace freegs::sfm {
namespace {

constexpr std::string_view kSpace = " \t\r";

// Lines of a text, trimmed, with their number.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}

  // The next line as it is; false at the end.
  bool Next(std::string_view* line) {
    if (rest_.empty()) return false;
    const size_t end = rest_.find('\n');
    *line = Trimmed(rest_.substr(0, end));
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    ++number_;
    return true;
  }

  // The next line that is neither empty nor a comment.
  bool NextContent(std::string_view* line) {
    while (Next(line)) {
      if (!line->empty() && line->front() != '#') return true;
    }
    return false;
  }

  Status Error(const std::string& fault) const {
    return BadInputError("line " + std::to_string(number_) + ": " + fault);
  }

 private:
  std::string_view rest_;
  int64_t number_ = 0;
};

// Words of one line.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(Trimmed(line)) {}

  bool empty() const { return rest_.empty(); }
  std::string_view rest() const { return rest_; }

  std::string_view Next() {
    const size_t end = rest_.find_first_of(kSpace);
    const std::string_view word = rest_.substr(0, end);
    rest_ = end == std::string_view::npos ? std::string_view()
                                          : Trimmed(rest_.substr(end));
    return word;
  }

  template <typename T>
  bool Read(T* value) {
    const std::string_view word = Next();
    const auto result =
        std::from_chars(word.data(), word.data() + word.size(), *value);
    return result.ec == std::errc() && result.ptr == word.data() + word.size();
  }

  bool ReadColour(uint8_t* value) {
    int number = 0;
    if (!Read(&number) || number < 0 || number > 255) return false;
    *value = static_cast<uint8_t>(number);
    return true;
  }

 private:
  std::string_view rest_;
};

template <typename T>
void Append(T value, std::string* text) {
  char buffer[64];
  const auto result = std::to_chars(buffer, buffer + sizeof(buffer), value);
  text->append(buffer, result.ptr);
}

Status ParseFeatures(const Lines& lines,
                     std::string_view line,
                     std::vector<Point2D>* points) {
  Words words(line);
  while (!words.empty()) {
    Point2D point;
    int64_t point3d_id = -1;
    if (!words.Read(&point.xy.x()) || !words.Read(&point.xy.y()) ||
        !words.Read(&point3d_id)) {
      return lines.Error(
          "expected X Y POINT3D_ID triples (an image takes two lines)");
    }
    if (point3d_id >= 0) point.point3d_id = static_cast<uint64_t>(point3d_id);
    points->push_back(point);
  }
  return {};
}

}  // namespace

Status ParseCamerasText(std::string_view text, std::vector<Camera>* cameras) {
  Lines lines(text);
  std::string_view line;
  while (lines.NextContent(&line)) {
    Words words(line);
    Camera camera;
    if (!words.Read(&camera.id)) return lines.Error("expected a camera id");
    const std::string name(words.Next());
    const StatusOr<StoredCameraModel> stored =
        FindStoredCameraModel(std::string_view(name));
    if (!stored.ok()) return lines.Error(stored.status().message());
    camera.model = stored->model;
    if (!words.Read(&camera.width) || !words.Read(&camera.height)) {
      return lines.Error("expected width and height");
    }
    camera.params.resize(stored->num_params);
    for (double& param : camera.params) {
      if (!words.Read(&param)) {
        return lines.Error(name + " needs " +
                           std::to_string(stored->num_params) + " parameters");
      }
    }
    if (!words.empty())
      return lines.Error("more parameters than " + name + " has");
    CompleteParameters(*stored, &camera.params);
    cameras->push_back(std::move(camera));
  }
  return {};
}

Status ParseImagesText(std::string_view text, std::vector<PosedImage>* images) {
  Lines lines(text);
  std::string_view line;
  while (lines.NextContent(&line)) {
    Words words(line);
    PosedImage image;
    Eigen::Quaterniond& q = image.cam_from_world.rotation;
    Eigen::Vector3d& t = image.cam_from_world.translation;
    if (!words.Read(&image.id) || !words.Read(&q.w()) || !words.Read(&q.x()) ||
        !words.Read(&q.y()) || !words.Read(&q.z()) || !words.Read(&t.x()) ||
        !words.Read(&t.y()) || !words.Read(&t.z()) ||
        !words.Read(&image.camera_id)) {
      return lines.Error(
          "expected IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID "
          "NAME");
    }
    if (words.empty()) return lines.Error("the image has no name");
    image.name = std::string(words.rest());
    if (std::abs(q.squaredNorm() - 1) > 1e-12) q.normalize();
    if (lines.Next(&line)) {
      FREEGS_RETURN_IF_ERROR(ParseFeatures(lines, line, &image.points2d));
    }
    images->push_back(std::move(image));
  }
  return {};
}

Status ParsePointsText(std::string_view text, std::vector<Point3D>* points) {
  Lines lines(text);
  std::string_view line;
  while (lines.NextContent(&line)) {
    Words words(line);
    Point3D point;
    if (!words.Read(&point.id) || !words.Read(&point.xyz.x()) ||
        !words.Read(&point.xyz.y()) || !words.Read(&point.xyz.z()) ||
        !words.ReadColour(&point.rgb[0]) || !words.ReadColour(&point.rgb[1]) ||
        !words.ReadColour(&point.rgb[2]) || !words.Read(&point.error)) {
      return lines.Error("expected POINT3D_ID X Y Z R G B ERROR");
    }
    while (!words.empty()) {
      TrackElement element;
      if (!words.Read(&element.image_id) ||
          !words.Read(&element.point2d_index)) {
        return lines.Error("expected IMAGE_ID POINT2D_IDX pairs");
      }
      point.track.push_back(element);
    }
    points->push_back(std::move(point));
  }
  return {};
}

std::string CamerasToText(const std::vector<Camera>& cameras) {
  std::string text = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
  for (const Camera& camera : cameras) {
    Append(camera.id, &text);
    text += ' ';
    text += GetCameraModel(camera.model).name;
    text += ' ';
    Append(camera.width, &text);
    text += ' ';
    Append(camera.height, &text);
    for (const double param : camera.params) {
      text += ' ';
      Append(param, &text);
    }
    text += '\n';
  }
  return text;
}

std::string ImagesToText(const std::vector<PosedImage>& images) {
  std::string text =
      "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME\n"
      "# (X Y POINT3D_ID)[]\n";
  for (const PosedImage& image : images) {
    const Eigen::Quaterniond& q = image.cam_from_world.rotation;
    const Eigen::Vector3d& t = image.cam_from_world.translation;
    Append(image.id, &text);
    for (const double v : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) {
      text += ' ';
      Append(v, &text);
    }
    text += ' ';
    Append(image.camera_id, &text);
    text += ' ' + image.name + '\n';
    const char* separator = "";
    for (const Point2D& point : image.points2d) {
      text += separator;
      separator = " ";
      Append(point.xy.x(), &text);
      text += ' ';
      Append(point.xy.y(), &text);
      text += ' ';
      if (point.point3d_id == kNoPoint3D) {
        text += "-1";
      } else {
        Append(point.point3d_id, &text);
      }
    }
    text += '\n';
  }
  return text;
}

std::string PointsToText(const std::vector<Point3D>& points) {
  std::string text =
      "# POINT3D_ID X Y Z R G B ERROR (IMAGE_ID POINT2D_IDX)[]\n";
  for (const Point3D& point : points) {
    Append(point.id, &text);
    for (const double v : {point.xyz.x(), point.xyz.y(), point.xyz.z()}) {
      text += ' ';
      Append(v, &text);
    }
    for (const uint8_t v : point.rgb) {
      text += ' ';
      Append(static_cast<int>(v), &text);
    }
    text += ' ';
    Append(point.error, &text);
    for (const TrackElement& element : point.track) {
      text += ' ';
      Append(element.image_id, &text);
      text += ' ';
      Append(element.point2d_index, &text);
    }
    text += '\n';
  }
  return text;
}

}  // namespace freegs::sfm
