// SPDX-License-Identifier: BSD-3-Clause
// Finds the photos that the names in a file of another program mean.

#ifndef FREEGS_SFM_IMPORT_NAME_MATCHING_H_
#define FREEGS_SFM_IMPORT_NAME_MATCHING_H_

#include <string>
#include <vector>

#include "sfm/scene/sfm_photo.h"

namespace freegs::sfm {

// Returns, for each name, the index of the photo that it means, or -1. Paths
// are compared from their ends: "images/0001.jpg" and "./0001" both mean the
// photo "0001.jpg". Of several photos that fit, the one with more equal folders
// wins, and then one with an equal extension. A name that two photos fit
// equally well means neither. When two names mean one photo, the better name
// gets it, and of equally good ones the earlier; the other name means none.
// "right/0001.jpg" does not mean "left/0001.jpg" where other photos lie in
// right or other names in left.
std::vector<int> MatchNames(const std::vector<std::string>& names,
                            const std::vector<SfmPhoto>& photos);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_IMPORT_NAME_MATCHING_H_
