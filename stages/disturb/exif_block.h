// SPDX-License-Identifier: BSD-3-Clause
// Takes the EXIF block out of a photo's file, and puts one into it. So a photo
// that is written anew keeps what its camera said.

#ifndef FREEGS_STAGES_DISTURB_EXIF_BLOCK_H_
#define FREEGS_STAGES_DISTURB_EXIF_BLOCK_H_

#include <string>
#include <string_view>

#include "core/status.h"
#include "photos/photo_exif.h"

namespace freegs::stages {

// The EXIF block of a JPEG or PNG file; empty when it has none, and for other
// files.
std::string ExifBlockOf(std::string_view file);

// The JPEG or PNG file with this EXIF block in place of its own; without one
// when the block is empty. kBadInput for other files, and for a block that does
// not fit.
StatusOr<std::string> WithExifBlock(std::string_view file,
                                    std::string_view block);

// A block that says orientation, make and model as `tags` have them, and a
// focal length of `focal` times the longest side of the picture.
std::string ExifBlockWithFocal(const photos::ExifTags& tags, double focal);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_DISTURB_EXIF_BLOCK_H_
