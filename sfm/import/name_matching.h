// SPDX-License-Identifier: BSD-3-Clause
// Finds the photos that the names in a file of another program mean.

#ifndef FREEGS_SFM_IMPORT_NAME_MATCHING_H_
#define FREEGS_SFM_IMPORT_NAME_MATCHING_H_

#include <string>
#include <vector>

#include "sfm/scene/sfm_photo.h"

namespace freegs::sfm {

// Two names that mean a photo equally well.
struct NameTie {
  int photo = 0;
  int taken = 0;  // The name that got the photo.
  int other = 0;  // The first one that did not.
};

struct NameMatches {
  // For each name, the index of the photo that it means, or -1.
  std::vector<int> photos;

  std::vector<NameTie> ties;  // In the order of the photos.
};

// Finds the photo that each name means. Paths are compared from their ends:
// "images/0001.jpg" and "./0001" both mean the photo "0001.jpg". Of several
// photos that fit, the one with more equal folders wins, and then one with an
// equal extension. A name that two photos fit equally well means neither. When
// two names mean one photo, the better name gets it, and the other one means
// none. Of equally good names it is the one that has `folder`, the name of the
// folder of the photos, above the photo's own path, or else the earlier one,
// and that is a tie. "right/0001.jpg" does not mean "left/0001.jpg" where other
// photos lie in right or other names in left.
NameMatches MatchNames(const std::vector<std::string>& names,
                       const std::vector<SfmPhoto>& photos,
                       const std::string& folder = "");

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_IMPORT_NAME_MATCHING_H_
