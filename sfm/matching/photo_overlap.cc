// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/matching/photo_overlap.h"

#include <algorithm>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "core/quantile.h"

namespace freegs::sfm {

StatusOr<int64_t> MatchesOfThirdPartner(const MatchDatabase& database) {
  constexpr size_t kPartner = 3;
  FREEGS_ASSIGN_OR_RETURN(const auto photos, database.Photos());
  FREEGS_ASSIGN_OR_RETURN(const auto pairs, database.VerifiedPairs());
  std::map<uint32_t, std::vector<int64_t>> partners;
  for (const MatchDatabase::VerifiedPair& pair : pairs) {
    partners[pair.id1].push_back(pair.num_matches);
    partners[pair.id2].push_back(pair.num_matches);
  }
  std::vector<int64_t> third;
  for (const MatchDatabase::Photo& photo : photos) {
    std::vector<int64_t>& matches = partners[photo.id];
    std::sort(matches.begin(), matches.end(), std::greater<>());
    third.push_back(matches.size() < kPartner ? 0 : matches[kPartner - 1]);
  }
  return LowerQuantile(std::move(third), 0.25);
}

}  // namespace freegs::sfm
