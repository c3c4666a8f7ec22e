// SPDX-License-Identifier: BSD-3-Clause
// How far COLMAP is, from the lines it prints.

#ifndef FREEGS_SFM_COLMAP_COLMAP_OUTPUT_H_
#define FREEGS_SFM_COLMAP_COLMAP_OUTPUT_H_

#include <optional>
#include <string_view>

namespace freegs::sfm {

struct ColmapProgress {
  enum class Kind {
    kPhotoDone,        // "Processed file [3/50]": done, total.
    kPhotoRegistered,  // "Registering image #7 (12)": done is the 12; no total.
    kPhotoUndistorted  // "Undistorting image [3/50]": done, total.
  };
  Kind kind = Kind::kPhotoDone;
  int done = 0;
  int total = 0;
};

// What a line of COLMAP 3.8 to 4.x says about progress; nothing for the others.
// Newer releases put a log prefix before the text, which is skipped.
std::optional<ColmapProgress> ParseColmapLine(std::string_view line);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_COLMAP_COLMAP_OUTPUT_H_
