// SPDX-License-Identifier: BSD-3-Clause
// Which photo a name in somebody else's file means.

#ifndef FREEGS_SFM_IMPORT_NAME_MATCHING_H_
#define FREEGS_SFM_IMPORT_NAME_MATCHING_H_

#include <string>
#include <vector>

#include "sfm/scene/sfm_photo.h"

namespace freegs::sfm {

// For each name the index of the photo it means, or -1. Paths are compared from
// their ends: "images/0001.jpg" and "./0001" both mean the photo "0001.jpg".
// More equal folders win over fewer, then an equal extension. A name that two
// photos fit equally well means neither; a photo that two names fit goes to the
// better, or the earlier.
std::vector<int> MatchNames(const std::vector<std::string>& names,
                            const std::vector<SfmPhoto>& photos);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_IMPORT_NAME_MATCHING_H_
