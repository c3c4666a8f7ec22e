// SPDX-License-Identifier: BSD-3-Clause
// Reads from a film by how much its frames must be turned to be upright.

#ifndef FREEGS_PHOTOS_FILM_ROTATION_H_
#define FREEGS_PHOTOS_FILM_ROTATION_H_

#include <filesystem>
#include <string_view>

namespace freegs::photos {

// Returns the clockwise turn in degrees (0, 90, 180 or 270) that the first
// video track of an MP4 or QuickTime file asks for. Returns 0 for other files,
// for damaged ones and for other angles. The program reads the turn itself
// because OpenCV 4.6 applies it in the wrong direction. Source: ISO
// 14496-12, 8.3.2 (tkhd) and 6.2.2 (matrix).
int FilmRotation(const std::filesystem::path& path);

// Does the same for the content of the box "moov" of such a file.
int MovieRotation(std::string_view moov);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_FILM_ROTATION_H_
