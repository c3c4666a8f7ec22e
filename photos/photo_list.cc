// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_list.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/files.h"

namespace freegs::photos {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr int kVersion = 1;
constexpr uint64_t kMaxFileBytes = uint64_t{256} << 20;
constexpr int kMaxDepth = 4;  // Root, photos, photo; one to spare.
constexpr int kMaxSide = 1 << 20;
constexpr double kMaxNumber = 1e12;

constexpr PhotoSplit kSplits[] = {
    PhotoSplit::kTrain, PhotoSplit::kHoldout, PhotoSplit::kRejected};

ordered_json OrNull(const std::optional<double>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

ordered_json ToJson(const Photo& photo) {
  ordered_json object;
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

// Reads the fields of one object; keeps the first fault.
class FieldReader {
 public:
  FieldReader(const json& object, std::string where)
      : object_(object), where_(std::move(where)) {
    if (!object.is_object()) Fail("", "is not an object");
  }

  void Text(const char* key, std::string* value) {
    const json* field = Find(key);
    if (field == nullptr) return;
    if (!field->is_string()) return Fail(key, "is not a text");
    *value = field->get<std::string>();
  }

  void Bool(const char* key, bool* value) {
    const json* field = Find(key);
    if (field == nullptr) return;
    if (!field->is_boolean()) return Fail(key, "is not true or false");
    *value = field->get<bool>();
  }

  void Int(const char* key, int min, int max, int* value) {
    const json* field = Find(key);
    if (field == nullptr) return;
    if (!field->is_number_integer()) return Fail(key, "is not a whole number");
    // As double: exact in the allowed range, and safe for any 64-bit number.
    const double number = field->get<double>();
    if (!(number >= min && number <= max)) return Fail(key, "is out of range");
    *value = static_cast<int>(number);
  }

  void Real(const char* key, double* value) {
    const json* field = Find(key);
    if (field == nullptr) return;
    if (!field->is_number()) return Fail(key, "is not a number");
    const double number = field->get<double>();
    if (!(number >= 0 && number <= kMaxNumber)) {
      return Fail(key, "is out of range");
    }
    *value = number;
  }

  void OptionalReal(const char* key, std::optional<double>* value) {
    const json* field = Find(key);
    if (field == nullptr || field->is_null()) return;
    double number = 0;
    Real(key, &number);
    *value = number;
  }

  bool Has(const char* key) const {
    return object_.is_object() && object_.contains(key);
  }

  void Fail(const std::string& key, const std::string& fault) {
    if (!error_.empty()) return;
    error_ = where_ + (key.empty() ? " " : "." + key + " ") + fault;
  }

  const std::string& error() const { return error_; }

 private:
  const json* Find(const char* key) {
    if (!error_.empty()) return nullptr;
    const auto found = object_.find(key);
    if (found == object_.end()) {
      Fail(key, "is missing");
      return nullptr;
    }
    return &*found;
  }

  const json& object_;
  std::string where_;
  std::string error_;
};

// A relative path that stays below its folder.
bool IsNameBelowFolder(const std::string& name) {
  if (name.empty() || name.find('\0') != std::string::npos) return false;
  const std::filesystem::path path(name);
  if (path.is_absolute() || !path.has_filename()) return false;
  return std::none_of(path.begin(), path.end(), [](const auto& part) {
    return part == ".." || part == ".";
  });
}

Photo ReadPhoto(FieldReader& reader) {
  Photo photo;
  reader.Text("file", &photo.file);
  reader.Text("name", &photo.name);
  reader.Text("format", &photo.format);
  reader.Bool("converted", &photo.converted);
  reader.Int("width", 0, kMaxSide, &photo.width);
  reader.Int("height", 0, kMaxSide, &photo.height);
  reader.Int("orientation", 1, 8, &photo.orientation);
  reader.Real("sharpness", &photo.sharpness);
  reader.Text("hash", &photo.hash);
  reader.Text("file_hash", &photo.file_hash);
  reader.Int("camera_group", -1, 1 << 30, &photo.camera_group);
  reader.Text("make", &photo.make);
  reader.Text("model", &photo.model);
  reader.OptionalReal("focal_length_mm", &photo.focal_length_mm);
  reader.OptionalReal("focal_length_35mm", &photo.focal_length_35mm);
  reader.OptionalReal("focal_length_px", &photo.focal_length_px);
  if (reader.Has("film")) {
    reader.Text("film", &photo.film);
    reader.Int("frame", 0, 1 << 30, &photo.frame);
    reader.Real("time_s", &photo.time_s);
  }
  if (reader.Has("mask")) reader.Bool("mask", &photo.has_mask);
  reader.Text("reason", &photo.reason);

  std::string split;
  reader.Text("split", &split);
  const auto found = std::find_if(
      std::begin(kSplits), std::end(kSplits), [&split](PhotoSplit known) {
        return SplitName(known) == split;
      });
  if (found == std::end(kSplits)) {
    reader.Fail("split", "is not train, holdout or rejected");
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
  ordered_json root;
  root["version"] = kVersion;
  root["images_folder"] = list.images_folder;
  ordered_json counts;
  for (const PhotoSplit split : kSplits) {
    counts[std::string(SplitName(split))] = list.Count(split);
  }
  root["counts"] = std::move(counts);
  root["photos"] = ordered_json::array();
  for (const Photo& photo : list.photos)
    root["photos"].push_back(ToJson(photo));
  return WriteFileAtomic(
      path,
      root.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n");
}

StatusOr<PhotoList> ReadPhotoList(const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string text,
                          ReadFile(path, kMaxFileBytes));
  return ParsePhotoList(text, path.string());
}

StatusOr<PhotoList> ParsePhotoList(std::string_view text,
                                   const std::string& source) {
  const auto fault = [&source](const std::string& what) {
    return BadInputError(source + ": " + what +
                         "; run the ingest stage again to write it anew");
  };
  // What lies deeper than our own format is dropped while parsing, so that
  // hostile nesting costs no memory.
  bool too_deep = false;
  const json root = json::parse(
      text,
      [&too_deep](int depth, json::parse_event_t, json&) {
        too_deep = too_deep || depth > kMaxDepth;
        return depth <= kMaxDepth;
      },
      /*allow_exceptions=*/false);
  if (root.is_discarded()) return fault("not valid JSON");
  if (too_deep) return fault("nested too deeply for a photo list");

  FieldReader top(root, "the document");
  int version = 0;
  PhotoList list;
  top.Int("version", 0, 1 << 30, &version);
  top.Text("images_folder", &list.images_folder);
  if (!top.error().empty()) return fault(top.error());
  if (version != kVersion) {
    return fault("version " + std::to_string(version) + " instead of " +
                 std::to_string(kVersion));
  }
  const auto photos = root.find("photos");
  if (photos == root.end() || !photos->is_array()) {
    return fault("photos is not a list");
  }
  std::set<std::string> names;
  for (size_t i = 0; i < photos->size(); ++i) {
    FieldReader reader((*photos)[i], "photos[" + std::to_string(i) + "]");
    Photo photo = ReadPhoto(reader);
    if (photo.usable() && !names.insert(photo.name).second) {
      reader.Fail("name", "is used twice");
    }
    if (!reader.error().empty()) return fault(reader.error());
    list.photos.push_back(std::move(photo));
  }
  return list;
}

}  // namespace freegs::photos
