// SPDX-License-Identifier: BSD-3-Clause
// Reads the progress of COLMAP from the lines that it prints.

#ifndef FREEGS_SFM_COLMAP_COLMAP_OUTPUT_H_
#define FREEGS_SFM_COLMAP_COLMAP_OUTPUT_H_

#include <optional>
#include <string_view>

namespace freegs::sfm {

struct ColmapProgress {
  enum class Kind {
    kPhotoRegistered,    // "Registering image #7 (12)": done 12, no total.
    kPhotoTriangulated,  // "Triangulating image #7 (11)": 11 are done, no
                         // total.
    kPhotoUndistorted,   // "Undistorting image [3/50]": done 3, total 50.
    kAdjusting           // "Global bundle adjustment", which has begun.
  };
  Kind kind = Kind::kPhotoRegistered;
  int done = 0;
  int total = 0;
};

// Returns the progress that a line of COLMAP 3.8 to 4.x tells, or nothing. The
// log prefix that newer releases put before the text is skipped.
std::optional<ColmapProgress> ParseColmapLine(std::string_view line);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_COLMAP_COLMAP_OUTPUT_H_
