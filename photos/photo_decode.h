// SPDX-License-Identifier: BSD-3-Clause
// Decodes photo files of any kind to upright 8-bit RGB pixels, or says why that
// is not possible.

#ifndef FREEGS_PHOTOS_PHOTO_DECODE_H_
#define FREEGS_PHOTOS_PHOTO_DECODE_H_

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <string_view>

#include "core/image.h"
#include "core/status.h"
#include "photos/photo_header.h"
#include "photos/photo_list.h"

namespace freegs::photos {

// Larger files are refused. This is about the file, not about its pixels.
inline constexpr uint64_t kMaxPhotoFileBytes = uint64_t{1} << 30;

struct PhotoDecodeOptions {
  // Limit in millions of pixels. Larger photos are refused before memory is
  // taken for them.
  double max_megapixels = 400;

  // The option that sets this limit, for messages; empty where none does.
  std::string max_megapixels_option = {};

  // Photos whose shorter side has fewer pixels than this are refused.
  int min_side = 32;

  // What transparent pixels show: "white" or "black".
  std::string background = "black";

  // Whether 16-bit samples become 255 unless they are 0, instead of being
  // divided. Masks need it.
  bool only_zero_is_black = false;

  Status Check() const;
};

// Checks that a photo's size is within the limits and that its file is
// complete, before it is decoded. The message of kBadInput is a phrase that
// says what is wrong and what to do.
Status CheckHeader(const PhotoHeader& header,
                   const PhotoDecodeOptions& options);

// Decodes a file whose header passed CheckHeader to upright 8-bit RGB pixels.
// 16-bit samples are divided by 257 and rounded, grey is repeated, and
// transparent pixels are laid over options.background. Returns kBadInput as
// CheckHeader does.
StatusOr<ImageU8> DecodePhoto(std::string_view bytes,
                              const PhotoHeader& header,
                              const PhotoDecodeOptions& options);

// Whether every program reads the file as DecodePhoto does. This holds for
// plain 8-bit JPEG and PNG files that are upright and opaque.
bool IsPlainPhoto(const PhotoHeader& header);

// The result of the inspection of one file. When the file cannot be used,
// photo.split is kRejected and photo.reason says why.
struct InspectedPhoto {
  Photo photo;
  // The pixels, when the file must be re-encoded because other programs might
  // read it differently (see IsPlainPhoto). Empty otherwise.
  ImageU8 pixels;

  bool may_be_transparent = false;  // Whether the file has alpha.
};

// Reads photo files:
//
//   PhotoDecodeOptions options;
//   FREEGS_RETURN_IF_ERROR(options.Check());
//   PhotoInspector inspector(options);
//   const InspectedPhoto photo = inspector.Inspect(folder, "a/b.jpg");
//   if (!photo.photo.usable()) Warn(photo.photo.reason);
//
// Several threads may use one inspector. Photos so large that two of them may
// not fit in memory are decoded one at a time.
class PhotoInspector {
 public:
  // `options` must have passed Check().
  explicit PhotoInspector(PhotoDecodeOptions options)
      : options_(std::move(options)) {}

  // Reads the file at folder / file. Fills in all fields of a Photo except
  // name, camera_group, and the choice between training and holdout.
  InspectedPhoto Inspect(const std::filesystem::path& folder,
                         const std::string& file);

 private:
  Status Decode(std::string_view bytes, InspectedPhoto* result);

  PhotoDecodeOptions options_;
  std::mutex large_photo_;
};

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_DECODE_H_
