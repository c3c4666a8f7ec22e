// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_list.h"

#include <algorithm>
#include <cstdint>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_fields.h"
#include "core/io/json_text.h"

namespace freegs::photos {
namespace {

using nlohmann::json;

constexpr int kVersion = 1;
constexpr uint64_t kMaxListBytes = uint64_t{256} << 20;
constexpr int kMaxSide = 1 << 20;
constexpr double kMaxNumber = 1e12;

constexpr PhotoSplit kSplits[] = {
    PhotoSplit::kTrain, PhotoSplit::kHoldout, PhotoSplit::kRejected};

json ToJson(const Photo& photo) {
  json object;
  object["file"] = photo.file;
  object["name"] = photo.name;
  object["format"] = photo.format;
  object["converted"] = photo.converted;
  object["width"] = photo.width;
  object["height"] = photo.height;
  object["orientation"] = photo.orientation;
  object["sharpness"] = photo.sharpness;
  object["hash"] = photo.hash;
  object["file_hash"] = photo.file_hash;
  object["camera_group"] = photo.camera_group;
  object["make"] = photo.make;
  object["model"] = photo.model;
  object["focal_length_mm"] = OrNull(photo.focal_length_mm);
  object["focal_length_35mm"] = OrNull(photo.focal_length_35mm);
  if (photo.digital_zoom != 1) object["digital_zoom"] = photo.digital_zoom;
  object["focal_length_px"] = OrNull(photo.focal_length_px);
  if (!photo.film.empty()) {
    object["film"] = photo.film;
    object["frame"] = photo.frame;
    object["time_s"] = photo.time_s;
  }
  if (photo.has_mask) object["mask"] = true;
  object["split"] = SplitName(photo.split);
  object["reason"] = photo.reason;
  return object;
}

Photo ReadPhoto(JsonObjectReader& reader) {
  // A focal length may be null, which means unknown.
  const auto optional_focal =
      [&reader](const char* key) -> std::optional<double> {
    if (reader.IsNull(key)) return std::nullopt;
    return reader.Number(key, 0, kMaxNumber);
  };
  Photo photo;
  photo.file = reader.Text("file");
  photo.name = reader.Text("name");
  photo.format = reader.Text("format");
  photo.converted = reader.Bool("converted");
  photo.width = reader.Integer("width", 0, kMaxSide);
  photo.height = reader.Integer("height", 0, kMaxSide);
  photo.orientation = reader.Integer("orientation", 1, 8);
  photo.sharpness = reader.Number("sharpness", 0, kMaxNumber);
  photo.hash = reader.Text("hash");
  photo.file_hash = reader.Text("file_hash");
  photo.camera_group = reader.Integer("camera_group", -1, 1 << 30);
  photo.make = reader.Text("make");
  photo.model = reader.Text("model");
  photo.focal_length_mm = optional_focal("focal_length_mm");
  photo.focal_length_35mm = optional_focal("focal_length_35mm");
  if (reader.Has("digital_zoom")) {
    photo.digital_zoom = reader.Number("digital_zoom", 0, kMaxNumber);
  }
  photo.focal_length_px = optional_focal("focal_length_px");
  if (reader.Has("film")) {
    photo.film = reader.Text("film");
    photo.frame = reader.Integer("frame", 0, 1 << 30);
    photo.time_s = reader.Number("time_s", 0, kMaxNumber);
  }
  if (reader.Has("mask")) photo.has_mask = reader.Bool("mask");
  photo.reason = reader.Text("reason");

  const std::string split = reader.Text("split");
  const auto found = std::find_if(
      std::begin(kSplits), std::end(kSplits), [&split](PhotoSplit known) {
        return SplitName(known) == split;
      });
  if (found == std::end(kSplits)) {
    reader.Fail("split", "must be train, holdout or rejected");
    return photo;
  }
  photo.split = *found;
  if (!photo.usable()) return photo;
  if (photo.width == 0) reader.Fail("width", "is 0");
  if (photo.height == 0) reader.Fail("height", "is 0");
  if (photo.camera_group < 0) reader.Fail("camera_group", "is negative");
  if (!IsNameBelowFolder(photo.name)) {
    reader.Fail("name", "is not the name of a file below the photo folder");
  }
  return photo;
}

// The list, or what is wrong with it.
StatusOr<PhotoList> ReadList(std::string_view text, const std::string& source) {
  FREEGS_ASSIGN_OR_RETURN(const json root, ParseJsonObject(text, source));
  Status status;
  JsonObjectReader top(root, source, "", &status);
  PhotoList list;
  const int version = top.Integer("version", 0, 1 << 30);
  if (version != kVersion) {
    top.Fail("version",
             "is " + std::to_string(version) + " instead of " +
                 std::to_string(kVersion));
  }
  list.images_folder = top.Text("images_folder");
  std::set<std::string> names;
  for (const json& value : top.List("photos")) {
    const std::string path =
        "photos[" + std::to_string(list.photos.size()) + "]";
    JsonObjectReader reader(value, source, path, &status);
    Photo photo = ReadPhoto(reader);
    if (photo.usable() && !names.insert(photo.name).second) {
      reader.Fail("name", "is used twice");
    }
    FREEGS_RETURN_IF_ERROR(status);
    list.photos.push_back(std::move(photo));
  }
  FREEGS_RETURN_IF_ERROR(status);
  return list;
}

}  // namespace

std::string_view SplitName(PhotoSplit split) {
  switch (split) {
    case PhotoSplit::kTrain:
      return "train";
    case PhotoSplit::kHoldout:
      return "holdout";
    case PhotoSplit::kRejected:
      return "rejected";
  }
  return "";
}

int PhotoList::Count(PhotoSplit split) const {
  return static_cast<int>(
      std::count_if(photos.begin(), photos.end(), [split](const Photo& photo) {
        return photo.split == split;
      }));
}

Status WritePhotoList(const std::filesystem::path& path,
                      const PhotoList& list) {
  json root;
  root["version"] = kVersion;
  root["images_folder"] = list.images_folder;
  json counts;
  for (const PhotoSplit split : kSplits) {
    counts[std::string(SplitName(split))] = list.Count(split);
  }
  root["counts"] = std::move(counts);
  root["photos"] = json::array();
  for (const Photo& photo : list.photos)
    root["photos"].push_back(ToJson(photo));
  return WriteFileAtomic(path, JsonText(root));
}

StatusOr<PhotoList> ReadPhotoList(const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string text,
                          ReadFile(path, kMaxListBytes));
  return ParsePhotoList(text, path.string());
}

StatusOr<PhotoList> ParsePhotoList(std::string_view text,
                                   const std::string& source) {
  StatusOr<PhotoList> list = ReadList(text, source);
  if (list.ok()) return list;
  return BadInputError(list.status().message() +
                       "; run the ingest stage again to write it anew");
}

}  // namespace freegs::photos
