// SPDX-License-Identifier: BSD-3-Clause
// Masks tell which pixels of a photo to use and which to ignore.

#ifndef FREEGS_PHOTOS_PHOTO_MASK_H_
#define FREEGS_PHOTOS_PHOTO_MASK_H_

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/image.h"
#include "core/status.h"
#include "photos/photo_decode.h"
#include "photos/photo_list.h"

namespace freegs::photos {

// Finds the mask of a photo in a folder that is laid out like the folder of
// photos. For the photo "a.jpg" the mask is "a.jpg.png", as COLMAP wants it, or
// "a.png". Returns its path relative to the folder, or nothing.
std::optional<std::string> FindMask(const std::filesystem::path& folder,
                                    const std::string& photo_file);

// Does the same for all photos of a scene. A photo without such a mask also
// takes that of its name without the first folder, as nerfstudio lays them out:
// "masks/a.png" for "images/a.png". But it does so only where no other photo
// has or could take the same mask.
std::vector<std::optional<std::string>> FindMasks(
    const std::filesystem::path& folder,
    const std::vector<std::string>& photo_files);

// Decodes a mask file to one channel of 0 (ignore) and 255 (use), with the size
// of the upright photo. In the file, black pixels are to be ignored and all
// others to be used; in a JPEG those from 128 on. Transparent pixels count as
// black. `invert` exchanges the two.
//
// If EXIF turns the photo by 90 degrees, a mask of the shape of the stored
// photo is turned with it. The mask of a square photo, or of one that EXIF
// turns upside down, must be upright: its shape does not tell. A mask of
// another size but the same shape is resized. Anything else is kBadInput; the
// message is a phrase that says what is wrong and what to do.
StatusOr<ImageU8> DecodeMask(std::string_view bytes,
                             const Photo& photo,
                             bool invert,
                             const PhotoDecodeOptions& options);

// The share of pixels to be used, in [0, 1].
double KeptShare(const ImageU8& mask);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_MASK_H_
