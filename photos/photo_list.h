// SPDX-License-Identifier: BSD-3-Clause
// The list of a scene's photos, and its file ingest/images.json.

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
  kHoldout,   // Gets a pose like the others, but training never sees it.
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

  // The format by the content of `file`: "JPEG", "PNG" or "TIFF". Empty if it
  // is not known.
  std::string format;

  // Whether `name` holds re-encoded pixels instead of a copy of `file`.
  bool converted = false;

  // Pixels of the upright photo. 0 if it was never decoded.
  int width = 0;
  int height = 0;

  // EXIF orientation of `file`, 1..8. The photo in the workspace is upright.
  int orientation = 1;

  // How sharp the photo is: see Sharpness in photo_pixels.h.
  double sharpness = 0;

  // `hash` is the hash of the upright 8-bit RGB pixels and their size, so it is
  // equal for equal pictures, however they are stored. `file_hash` is the hash
  // of the file's bytes. They are empty if the photo could not be decoded or
  // read.
  std::string hash;
  std::string file_hash;

  // Photos of the same group have the same size, camera and focal length.
  // Groups are numbered from 0 in the order of their first photos; rejected
  // photos have -1.
  int camera_group = -1;

  // From EXIF.
  std::string make;
  std::string model;
  std::optional<double> focal_length_mm;
  std::optional<double> focal_length_35mm;
  double digital_zoom = 1;

  // Focal length in pixels that EXIF implies.
  std::optional<double> focal_length_px;

  // Only for a frame of a film: the film's file relative to the user's folder,
  // the number of the frame, counted from 0, and its time in seconds. Empty and
  // 0 for photos.
  std::string film;
  int frame = 0;
  double time_s = 0;

  // Whether ingest wrote a mask for the photo.
  bool has_mask = false;

  PhotoSplit split = PhotoSplit::kTrain;

  // Why the photo is rejected and what to do, in one line.
  std::string reason;

  bool usable() const { return split != PhotoSplit::kRejected; }
};

struct PhotoList {
  // The name of the folder or film that the user gave. It is never opened; only
  // names are compared with it. Files of older programs have the path.
  std::string images_folder;
  std::vector<Photo> photos;  // In natural order of `file`.

  int Count(PhotoSplit split) const;
};

// Writes the list. In names that are not valid UTF-8, the bytes that are not
// are replaced by U+FFFD.
Status WritePhotoList(const std::filesystem::path& path, const PhotoList& list);

// Reads the list. Returns kBadInput, with the names of file and field, for
// anything that WritePhotoList would not have written: missing fields, wrong
// types, values out of range, and names that occur twice or lead out of the
// photo folder.
StatusOr<PhotoList> ReadPhotoList(const std::filesystem::path& path);

// Does the same for the text of such a file. Messages name `source`.
StatusOr<PhotoList> ParsePhotoList(std::string_view json,
                                   const std::string& source);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_LIST_H_
