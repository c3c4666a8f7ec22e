// SPDX-License-Identifier: BSD-3-Clause
// How well photos hang together by their matches.
//
// A photo is placed by the points that it shares with others. One that shares
// many points with one other photo alone says little about where the two are,
// so that the third best partner is asked.

#ifndef FREEGS_SFM_MATCHING_PHOTO_OVERLAP_H_
#define FREEGS_SFM_MATCHING_PHOTO_OVERLAP_H_

#include <cstdint>

#include "core/status.h"
#include "sfm/matching/match_database.h"

namespace freegs::sfm {

// The number of verified matches that a photo has with its third best partner,
// at the lower quartile of all photos. A photo with fewer partners has 0.
StatusOr<int64_t> MatchesOfThirdPartner(const MatchDatabase& database);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MATCHING_PHOTO_OVERLAP_H_
