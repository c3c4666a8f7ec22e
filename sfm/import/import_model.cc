// SPDX-License-Identifier: BSD-3-Clause
// Imports COLMAP models and transforms files.

#include "sfm/import/import_model.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <system_error>
#include <tuple>
#include <utility>

#include "core/io/files.h"
#include "core/text.h"
#include "sfm/import/name_matching.h"
#include "sfm/import/quarter_turn.h"
#include "sfm/import/resize.h"
#include "sfm/import/transforms_json.h"
#include "sfm/scene/model_io.h"
#include "sfm/scene/random_points.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxTransformsBytes = uint64_t{1} << 28;

// A quarter turn of a photo whose sides differ by less may go unseen.
constexpr double kAlmostSquare = 0.01;

bool IsFile(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

Status NoMatch(const std::string& example, const SfmPhoto& photo) {
  return BadInputError(
      "none of its names fits a photo: it has, for example, '" + example +
      "', and the photos are like '" + photo.name +
      "'; give the photos that the poses belong to");
}

// Returns for each photo the index of the name that belongs to it, -1 for none.
// Appends to the result the names that belong to no photo, and a warning of
// photos that two names fit equally well. kBadInput if no name belongs to a
// photo.
StatusOr<std::vector<int>> MatchByName(const std::vector<std::string>& names,
                                       const std::vector<SfmPhoto>& photos,
                                       const std::string& folder,
                                       ImportedModel* result) {
  const NameMatches match = MatchNames(names, photos, folder);
  std::vector<int> name_of_photo(photos.size(), -1);
  for (size_t i = 0; i < names.size(); ++i) {
    if (match.photos[i] < 0) {
      result->unmatched.push_back(names[i]);
    } else {
      name_of_photo[match.photos[i]] = static_cast<int>(i);
    }
  }
  if (result->unmatched.size() == names.size()) {
    return NoMatch(names[0], photos[0]);
  }
  if (!match.ties.empty()) {
    std::vector<std::string> tied;
    for (const NameTie& tie : match.ties) {
      tied.push_back(photos[tie.photo].name);
    }
    const NameTie& first = match.ties[0];
    result->warnings.push_back(
        "of photos that two imported names fit equally well the first name was "
        "taken, which may be wrong (" +
        tied[0] + " may be " + names[first.taken] + " or " +
        names[first.other] +
        "); give the folder above the photos, so that their folders tell them "
        "apart: " +
        SomeNames(tied));
  }
  return name_of_photo;
}

// The turns that bring a picture of this size to that of the photo, which EXIF
// turned; 0 if it has the photo's shape already, or no turn helps.
int TurnsToPhoto(double width, double height, const SfmPhoto& photo) {
  const bool fits = IsResized(width, height, photo.width, photo.height);
  const bool fits_turned = IsResized(height, width, photo.width, photo.height);
  return !fits && fits_turned ? QuarterTurns(photo.orientation) : 0;
}

// Tells once which poses were made of the stored photos and turned.
void TellOfTurned(const std::vector<std::string>& photos,
                  const std::string& source,
                  std::vector<std::string>* warnings) {
  if (photos.empty()) return;
  warnings->push_back(
      source + ": made for photos as they are stored, so " +
      "their poses were turned as EXIF turns the photos: " + SomeNames(photos));
}

// Makes camera and features fit a photo of another size.
Status FitToPhoto(const SfmPhoto& photo, Camera* camera, PosedImage* image) {
  const double sx = static_cast<double>(photo.width) / camera->width;
  const double sy = static_cast<double>(photo.height) / camera->height;
  if (sx == 1 && sy == 1) return {};
  if (!IsResized(static_cast<double>(camera->width),
                 static_cast<double>(camera->height),
                 photo.width,
                 photo.height)) {
    return BadInputError(
        "'" + image->name + "' is " + std::to_string(camera->width) + " x " +
        std::to_string(camera->height) + " pixels there and the photo '" +
        photo.name + "' is " + std::to_string(photo.width) + " x " +
        std::to_string(photo.height) +
        ", another shape: the poses belong to other (rotated or cropped) "
        "photos");
  }
  *camera = camera->Resized(photo.width, photo.height);
  for (Point2D& point : image->points2d) {
    point.xy = Eigen::Vector2d(point.xy.x() * sx, point.xy.y() * sy);
  }
  return {};
}

// Whether EXIF turned the photo in a way that a size does not show.
bool IsTurnedUnseen(const SfmPhoto& photo, bool size_known) {
  if (photo.orientation == 1) return false;
  const double shape = static_cast<double>(photo.width) / photo.height;
  return photo.orientation <= 4 || !size_known ||
         std::abs(shape * shape - 1) < kAlmostSquare;
}

// Tells once that cameras were made to fit photos of other sizes: the numbers
// do not show whether the photos were resized, or cropped to this shape.
void WarnOfScaled(const std::vector<std::string>& photos,
                  const std::string& source,
                  std::vector<std::string>* warnings) {
  if (photos.empty()) return;
  warnings->push_back(
      source + ": made for images of another size than these photos, so its " +
      "intrinsics were scaled; that is right for photos that were resized, " +
      "and wrong for photos that were cropped: " + SomeNames(photos));
}

// Gives equal cameras one id.
class CameraSet {
 public:
  uint32_t Add(Camera camera, uint64_t origin) {
    const auto key = std::tuple(
        origin, camera.model, camera.width, camera.height, camera.params);
    const auto [it, added] =
        ids_.emplace(key, static_cast<uint32_t>(cameras_.size() + 1));
    if (added) {
      camera.id = it->second;
      cameras_.push_back(std::move(camera));
    }
    return it->second;
  }
  std::vector<Camera> Take() { return std::move(cameras_); }

 private:
  std::map<
      std::
          tuple<uint64_t, CameraModel, uint64_t, uint64_t, std::vector<double>>,
      uint32_t>
      ids_;
  std::vector<Camera> cameras_;
};

StatusOr<ImportedModel> ImportColmap(const fs::path& folder,
                                     const std::vector<SfmPhoto>& photos,
                                     const std::string& photo_folder) {
  FREEGS_ASSIGN_OR_RETURN(Reconstruction source, ReadModel(folder));
  if (source.images.empty()) {
    return BadInputError(folder.string() + ": the model has no images");
  }
  std::vector<std::string> names;
  for (const PosedImage& image : source.images) names.push_back(image.name);
  ImportedModel result;
  const StatusOr<std::vector<int>> match =
      MatchByName(names, photos, photo_folder, &result);
  if (!match.ok()) return match.status().Annotated(folder.string());
  const std::vector<int>& image_of_photo = *match;

  const auto camera_index = IndexCameras(source);
  CameraSet cameras;
  std::vector<std::string> scaled;
  std::vector<std::string> turned;
  for (size_t p = 0; p < photos.size(); ++p) {
    if (image_of_photo[p] < 0) continue;
    PosedImage image = std::move(source.images[image_of_photo[p]]);
    Camera camera = source.cameras[camera_index.at(image.camera_id)];
    if (const int turns = TurnsToPhoto(static_cast<double>(camera.width),
                                       static_cast<double>(camera.height),
                                       photos[p])) {
      TurnClockwise(turns, &camera, &image);
      turned.push_back(photos[p].name);
    }
    if (camera.width != static_cast<uint64_t>(photos[p].width) ||
        camera.height != static_cast<uint64_t>(photos[p].height)) {
      scaled.push_back(photos[p].name);
    }
    FREEGS_RETURN_IF_ERROR(
        FitToPhoto(photos[p], &camera, &image).Annotated(folder.string()));
    // Cameras that the source keeps apart stay apart.
    image.camera_id = cameras.Add(std::move(camera), image.camera_id);
    image.name = photos[p].name;
    if (IsTurnedUnseen(photos[p], true)) result.turned.push_back(image.name);
    result.model.images.push_back(std::move(image));
  }
  TellOfTurned(turned, folder.string(), &result.warnings);
  WarnOfScaled(scaled, folder.string(), &result.warnings);
  result.model.cameras = cameras.Take();
  result.model.points3d = std::move(source.points3d);

  // Observations in images that were left out go without a word; others that
  // point nowhere mean that the source is not quite consistent.
  const size_t dangling = RemoveDanglingReferences(&result.model);
  if (dangling > 0 && result.unmatched.empty()) {
    result.warnings.push_back(
        folder.string() + ": removed " + std::to_string(dangling) +
        " references between features and points that did not agree");
  }
  return result;
}

struct NamedFrame {
  TransformsFrame frame;
  bool holdout = false;
};

std::string PlainPath(const std::string& path) {
  return fs::path(path).lexically_normal().string();
}

// Appends the frames of a file, without those that another file has already.
// With `holdout` all of them are for evaluation, otherwise those that the file
// lists.
Status ReadFrames(const fs::path& path,
                  bool holdout,
                  std::vector<NamedFrame>* frames,
                  ImportedModel* result) {
  FREEGS_ASSIGN_OR_RETURN(const std::string text,
                          ReadFile(path, kMaxTransformsBytes));
  StatusOr<TransformsFile> parsed = ParseTransforms(text);
  if (!parsed.ok()) return parsed.status().Annotated(path.string());
  std::set<std::string> listed;
  for (const std::string& name : parsed->holdout) {
    listed.insert(PlainPath(name));
  }
  std::set<std::string> known;
  for (const NamedFrame& earlier : *frames) {
    known.insert(PlainPath(earlier.frame.file_path));
  }
  std::vector<std::string> again;
  for (TransformsFrame& frame : parsed->frames) {
    const std::string plain = PlainPath(frame.file_path);
    if (known.contains(plain)) {
      again.push_back(std::move(frame.file_path));
    } else {
      frames->push_back({std::move(frame), holdout || listed.contains(plain)});
    }
  }
  if (!again.empty()) {
    result->warnings.push_back(
        path.string() +
        ": has photos that a transforms file before it has too; the pose there "
        "is taken, and only that file decides whether they are for "
        "evaluation: " +
        SomeNames(again));
  }
  result->names_masks = result->names_masks || parsed->names_masks;
  if (!parsed->points_file.empty()) {
    result->warnings.push_back(path.string() +
                               ": the points of its ply_file_path are not "
                               "used: " +
                               parsed->points_file);
  }
  return {};
}

StatusOr<ImportedModel> ImportTransforms(const ImportSource& source,
                                         const std::vector<SfmPhoto>& photos,
                                         const std::string& photo_folder) {
  ImportedModel result;
  std::vector<NamedFrame> frames;
  FREEGS_RETURN_IF_ERROR(
      ReadFrames(source.transforms, false, &frames, &result));
  for (const fs::path& path : source.holdout_transforms) {
    FREEGS_RETURN_IF_ERROR(ReadFrames(path, true, &frames, &result));
  }
  std::vector<std::string> names;
  for (const NamedFrame& frame : frames) names.push_back(frame.frame.file_path);
  const StatusOr<std::vector<int>> match =
      MatchByName(names, photos, photo_folder, &result);
  if (!match.ok()) {
    return match.status().Annotated(source.transforms.string());
  }
  const std::vector<int>& frame_of_photo = *match;

  CameraSet cameras;
  std::vector<std::string> scaled;
  std::vector<std::string> turned;
  for (size_t p = 0; p < photos.size(); ++p) {
    if (frame_of_photo[p] < 0) continue;
    const NamedFrame& named = frames[frame_of_photo[p]];
    const TransformsIntrinsics& given = named.frame.intrinsics;
    // Those of the picture that the pose belongs to.
    int width = photos[p].width;
    int height = photos[p].height;
    const bool size_known = given.width > 0 && given.height > 0;
    const int turns =
        size_known ? TurnsToPhoto(given.width, given.height, photos[p]) : 0;
    if (turns != 0) std::swap(width, height);
    StatusOr<Camera> camera = MakeCamera(given, width, height);
    if (!camera.ok()) {
      return camera.status().Annotated(source.transforms.string() + ": '" +
                                       named.frame.file_path + "'");
    }
    PosedImage image;
    image.id = static_cast<uint32_t>(result.model.images.size() + 1);
    image.name = photos[p].name;
    image.cam_from_world = named.frame.cam_from_world;
    if (turns != 0) {
      TurnClockwise(turns, &*camera, &image);
      turned.push_back(image.name);
    }
    image.camera_id = cameras.Add(std::move(*camera), 0);
    if (named.holdout) result.holdout.push_back(image.name);
    if ((given.width > 0 && given.width != width) ||
        (given.height > 0 && given.height != height)) {
      scaled.push_back(image.name);
    }
    if (IsTurnedUnseen(photos[p], size_known)) {
      result.turned.push_back(image.name);
    }
    result.model.images.push_back(std::move(image));
  }
  TellOfTurned(turned, source.transforms.string(), &result.warnings);
  WarnOfScaled(scaled, source.transforms.string(), &result.warnings);
  result.model.cameras = cameras.Take();
  return result;
}

}  // namespace

std::vector<fs::path> ImportSource::Files() const {
  std::vector<fs::path> files;
  if (!colmap_model.empty()) {
    const bool binary = DetectModelFormat(colmap_model) == ModelFormat::kBinary;
    for (const char* name : {"cameras", "images", "points3D"}) {
      files.push_back(colmap_model /
                      (std::string(name) + (binary ? ".bin" : ".txt")));
    }
  }
  if (!transforms.empty()) files.push_back(transforms);
  files.insert(
      files.end(), holdout_transforms.begin(), holdout_transforms.end());
  return files;
}

std::vector<fs::path> ModelFolders(const fs::path& folder) {
  return {folder, folder / "sparse" / "0", folder / "sparse", folder / "0"};
}

StatusOr<ImportSource> FindImportSource(const fs::path& path) {
  ImportSource source;
  std::error_code error;
  fs::path file;
  if (IsFile(path)) {
    if (path.extension() == ".json") file = path;
    // One file of a COLMAP model stands for its folder.
    if (const auto format = DetectModelFormat(path.parent_path())) {
      if (path.extension() == ".txt" && *format == ModelFormat::kBinary) {
        return BadInputError(
            path.string() +
            ": the .bin files beside it would be read in its place; move them "
            "away, or name one of them (sfm.import)");
      }
      if (path.extension() == ".bin" || path.extension() == ".txt") {
        source.colmap_model = path.parent_path();
        return source;
      }
    }
  } else if (fs::is_directory(path, error)) {
    for (const fs::path& folder : ModelFolders(path)) {
      if (DetectModelFormat(folder)) {
        source.colmap_model = folder;
        return source;
      }
    }
    for (const char* name : {"transforms.json", "transforms_train.json"}) {
      if (file.empty() && IsFile(path / name)) file = path / name;
    }
  } else {
    return BadInputError(path.string() +
                         ": no such file or folder (sfm.import)");
  }
  if (file.empty()) {
    return BadInputError(
        path.string() +
        ": neither a COLMAP model (cameras, images and points3D as .bin or "
        ".txt, also in sparse/0, sparse or 0 below it) nor a transforms.json "
        "or transforms_train.json (sfm.import)");
  }
  source.transforms = file;
  if (file.filename() != "transforms_train.json") return source;
  for (const char* name : {"transforms_test.json", "transforms_val.json"}) {
    const fs::path holdout = file.parent_path() / name;
    if (IsFile(holdout)) source.holdout_transforms.push_back(holdout);
  }
  return source;
}

StatusOr<ImportedModel> ImportModel(const ImportSource& source,
                                    const std::vector<SfmPhoto>& photos,
                                    const ImportOptions& options) {
  if (photos.empty()) return BadInputError("there are no photos");
  StatusOr<ImportedModel> imported =
      source.colmap_model.empty()
          ? ImportTransforms(source, photos, options.folder)
          : ImportColmap(source.colmap_model, photos, options.folder);
  if (!imported.ok()) return imported.status();
  ImportedModel result = std::move(*imported);
  const std::string name =
      (source.colmap_model.empty() ? source.transforms : source.colmap_model)
          .string();
  if (result.model.points3d.empty()) {
    result.random_points = true;
    StatusOr<std::vector<Point3D>> points =
        RandomPoints(result.model, options.random_points, options.seed);
    if (!points.ok()) return points.status().Annotated(name);
    result.model.points3d = *std::move(points);
  }
  // What was computed from the source's numbers may be out of range although
  // they were not.
  FREEGS_RETURN_IF_ERROR(CheckReconstruction(result.model).Annotated(name));
  return result;
}

}  // namespace freegs::sfm
