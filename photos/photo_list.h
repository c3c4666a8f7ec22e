// SPDX-License-Identifier: BSD-3-Clause
// What is known about the photos of a scene, and the file that keeps it:
// ingest/images.json.

#ifndef FREEGS_PHOTOS_PHOTO_LIST_H_
#define FREEGS_PHOTOS_PHOTO_LIST_H_

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"

namespace freegs::photos {

enum class PhotoSplit {
  kTrain,
  kHoldout,   // Gets a pose like the others, but is never trained on.
  kRejected,  // Not used; Photo::reason says why.
};

// "train", "holdout", "rejected".
std::string_view SplitName(PhotoSplit split);

struct Photo {
  // The file in the user's folder, relative to it, with '/' between folders. A
  // frame of a film counts as a file in a folder of the film's name:
  // "film.mp4/frame_000012.jpg".
  std::string file;

  // The file in the workspace's photo folder, relative to it: `file` itself
  // unless the photo had to be re-encoded or its name is one that COLMAP's text
  // files cannot carry. Unique. Empty for rejected photos.
  std::string name;

  // What `file` is by its content: "JPEG", "PNG" or "TIFF". Empty if unknown.
  std::string format;

  // True if `name` holds re-encoded pixels instead of a copy of `file`.
  bool converted = false;

  // Pixels, after the EXIF orientation is applied. 0 if never decoded.
  int width = 0;
  int height = 0;

  // EXIF orientation of `file`, 1..8. The photo in the workspace is upright.
  int orientation = 1;

  // Variance of the Laplacian of the grey photo reduced to at most 512 pixels
  // (see Sharpness in photo_pixels.h).
  double sharpness = 0;

  // Hash of the upright 8-bit RGB pixels and their size: equal for equal
  // pictures, however they are stored. And of the file's bytes. Empty if the
  // photo could not be decoded or read.
  std::string hash;
  std::string file_hash;

  // Photos of equal number have the same size, camera and focal length.
  // Numbered from 0 in order of appearance; -1 for rejected photos.
  int camera_group = -1;

  // From EXIF.
  std::string make;
  std::string model;
  std::optional<double> focal_length_mm;
  std::optional<double> focal_length_35mm;

  // Focal length in pixels that EXIF implies.
  std::optional<double> focal_length_px;

  // For a frame of a film: the film, relative to the user's folder, the number
  // of the frame from 0, and its time in seconds. Empty and 0 for photos.
  std::string film;
  int frame = 0;
  double time_s = 0;

  // Whether ingest wrote a mask for it.
  bool has_mask = false;

  PhotoSplit split = PhotoSplit::kTrain;

  // Why the photo is rejected and what to do, in one line.
  std::string reason;

  bool usable() const { return split != PhotoSplit::kRejected; }
};

struct PhotoList {
  std::string images_folder;  // As the user gave it; for information only.
  std::vector<Photo> photos;  // In natural order of `file`.

  int Count(PhotoSplit split) const;
};

// File names that are not UTF-8 have their odd bytes replaced by U+FFFD.
Status WritePhotoList(const std::filesystem::path& path, const PhotoList& list);

// kBadInput, naming the file and the field, for anything that WritePhotoList
// would not have written: missing fields, wrong types, values out of range,
// names used twice or leading out of the photo folder.
StatusOr<PhotoList> ReadPhotoList(const std::filesystem::path& path);

// The same from text, for messages that name `source`.
StatusOr<PhotoList> ParsePhotoList(std::string_view json,
                                   const std::string& source);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_LIST_H_
