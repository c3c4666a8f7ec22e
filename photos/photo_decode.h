// SPDX-License-Identifier: BSD-3-Clause
// Any photo file to upright 8-bit RGB pixels, or a reason why not.

#ifndef FREEGS_PHOTOS_PHOTO_DECODE_H_
#define FREEGS_PHOTOS_PHOTO_DECODE_H_

#include <filesystem>
#include <mutex>
#include <string>
#include <string_view>

#include "core/image.h"
#include "core/status.h"
#include "photos/photo_header.h"
#include "photos/photo_list.h"

namespace freegs::photos {

struct PhotoDecodeOptions {
  // Larger photos are refused before memory is reserved for them (millions of
  // pixels).
  double max_megapixels = 400;

  // Photos with a shorter side than this are refused (pixels).
  int min_side = 32;

  // What transparent pixels show: "white" or "black".
  std::string background = "white";

  Status Check() const;
};

// Whether a photo of this header is worth decoding: size within the limits,
// data complete. kBadInput with a phrase that says what is wrong and what to
// do.
Status CheckHeader(const PhotoHeader& header,
                   const PhotoDecodeOptions& options);

// Pixels of a file whose header passed CheckHeader: 8-bit RGB, upright. 16-bit
// samples are divided by 257 and rounded, grey is repeated, transparent pixels
// are laid over options.background. kBadInput as above.
StatusOr<ImageU8> DecodePhoto(std::string_view bytes,
                              const PhotoHeader& header,
                              const PhotoDecodeOptions& options);

// True if every program reads the file as DecodePhoto does: a plain 8-bit JPEG
// or PNG, upright and opaque.
bool IsPlainPhoto(const PhotoHeader& header);

// What inspection of one file found. `photo.split` is kRejected, with a reason,
// if it cannot be used.
struct InspectedPhoto {
  Photo photo;
  // Pixels, if the file has to be re-encoded for others to read it the same
  // way; otherwise empty.
  ImageU8 pixels;
};

// Reads photo files. Safe to use from several threads at once; photos so large
// that two of them may not fit in memory are decoded one at a time.
class PhotoInspector {
 public:
  // Options have been checked.
  explicit PhotoInspector(PhotoDecodeOptions options)
      : options_(std::move(options)) {}

  // Fills everything of a Photo but name, camera_group and the choice between
  // training and holdout. `file` is the photo's path below `folder`.
  InspectedPhoto Inspect(const std::filesystem::path& folder,
                         const std::string& file);

 private:
  Status Decode(std::string_view bytes, InspectedPhoto* result);

  PhotoDecodeOptions options_;
  std::mutex large_photo_;
};

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_DECODE_H_
