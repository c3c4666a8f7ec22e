// SPDX-License-Identifier: BSD-3-Clause
// How a film has to be turned to be upright.

#ifndef FREEGS_PHOTOS_FILM_ROTATION_H_
#define FREEGS_PHOTOS_FILM_ROTATION_H_

#include <filesystem>
#include <string_view>

namespace freegs::photos {

// The quarter turns, clockwise in degrees (0, 90, 180 or 270), that the first
// video track of an MP4 or QuickTime file asks for; 0 for other files, damaged
// ones and other angles. Read here because OpenCV 4.6 turns the wrong way.
// Source: ISO 14496-12, 8.3.2 (tkhd) and 6.2.2 (matrix).
int FilmRotation(const std::filesystem::path& path);

// The same from the content of the box "moov".
int MovieRotation(std::string_view moov);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_FILM_ROTATION_H_
