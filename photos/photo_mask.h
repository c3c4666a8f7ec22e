// SPDX-License-Identifier: BSD-3-Clause
// Masks beside photos: which pixels to look at.

#ifndef FREEGS_PHOTOS_PHOTO_MASK_H_
#define FREEGS_PHOTOS_PHOTO_MASK_H_

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "core/image.h"
#include "core/status.h"
#include "photos/photo_decode.h"
#include "photos/photo_list.h"

namespace freegs::photos {

// The mask of a photo in a folder of masks that is laid out as the folder of
// photos: "a.jpg.png" (COLMAP's way) or "a.png" for the photo "a.jpg", relative
// to the folder; nothing if there is neither.
std::optional<std::string> FindMask(const std::filesystem::path& folder,
                                    const std::string& photo_file);

// Pixels of a mask file as 0 (ignore) and 255 (look at), one channel, of the
// size of `photo` as ingest writes it (upright). In the file, black is ignored
// and anything else looked at (in a JPEG, from 128); transparent pixels count
// as black. `invert` exchanges the two.
//
// A mask of the photo's stored size is turned with the photo where EXIF turns
// it onto its side; one of another size but the same shape is resized. Anything
// else is kBadInput with a phrase that says what is wrong and what to do.
StatusOr<ImageU8> DecodeMask(std::string_view bytes,
                             const Photo& photo,
                             bool invert,
                             const PhotoDecodeOptions& options);

// Share of pixels that are looked at, 0..1.
double KeptShare(const ImageU8& mask);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_MASK_H_
