// SPDX-License-Identifier: BSD-3-Clause
// Chooses which pairs of photos to match. The time for all pairs grows with the
// square of the number of photos, and each pair that shows different places may
// give wrong matches.

#ifndef FREEGS_SFM_MATCHING_PAIR_SELECTION_H_
#define FREEGS_SFM_MATCHING_PAIR_SELECTION_H_

#include <cstddef>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"
#include "sfm/matching/global_descriptor.h"

namespace freegs::sfm {

struct PairSelectionOptions {
  // "exhaustive": all pairs.
  // "retrieval": each photo with those that look most alike.
  // "sequential": as retrieval, and also photos that follow each other in the
  // given order.
  // "auto": as exhaustive for up to max_exhaustive photos. For more, as
  // retrieval, and also photos that follow each other by the numbers in their
  // names, where such photos turn out to look alike.
  std::string matcher = "auto";
  int max_exhaustive = 40;

  // Retrieval matches each photo with so many of those that look most alike.
  int num_neighbours = 15;

  // In a sequence each photo is matched with so many before it and after it.
  int overlap = 5;

  Status Check() const;
};

// The indices i < j of two photos.
using PhotoPair = std::pair<int, int>;

// How alike every two photos look: the similarity of their GlobalDescriptors.
class PhotoSimilarity {
 public:
  PhotoSimilarity() = default;
  PhotoSimilarity(const GlobalDescriptors& descriptors, ThreadPool& pool);

  int count() const { return count_; }
  float at(int i, int j) const {
    return values_[static_cast<size_t>(i) * count_ + j];
  }

  // All other photos. The most alike comes first, and of equally alike ones
  // that with the smaller index.
  std::vector<int> MostAlike(int photo) const;

 private:
  int count_ = 0;
  std::vector<float> values_;  // count_ x count_, symmetric.
};

// How many pairs were matched, for reports.
struct MatchedPairs {
  std::string strategy;  // See PairSelection; empty when nothing was matched.
  size_t pairs = 0;
  size_t all_pairs = 0;
};

struct PairSelection {
  // "exhaustive", "retrieval" or "sequence and retrieval".
  std::string strategy;
  std::vector<PhotoPair> pairs;  // Ascending, each once.
};

// Whether SelectPairs needs to know how alike the photos look.
bool NeedsSimilarity(int num_photos, const PairSelectionOptions& options);

// Chooses the first pairs to match, among photos with the given names:
//
//   PhotoSimilarity similarity;
//   if (NeedsSimilarity(num_photos, options)) {
//     similarity = PhotoSimilarity(DescribePhotos(features, {}, pool), pool);
//   }
//   const PairSelection selection = SelectPairs(names, similarity, options);
//
// A chain of these pairs connects every two photos. `similarity` must be that
// of the same photos; it may be empty unless NeedsSimilarity() is true.
PairSelection SelectPairs(const std::vector<std::string>& names,
                          const PhotoSimilarity& similarity,
                          const PairSelectionOptions& options);

// Chooses more pairs, in ascending order, after the pairs `tried` were matched.
// `verified` are those of them whose matches fit a motion of the camera. The
// new pairs are for photos that have too few verified pairs, and between groups
// of photos that no verified pair connects. The result is empty when there are
// no such photos, when all pairs were tried, or when `similarity` is empty.
std::vector<PhotoPair> SelectMorePairs(const PhotoSimilarity& similarity,
                                       const std::set<PhotoPair>& tried,
                                       const std::vector<PhotoPair>& verified,
                                       const PairSelectionOptions& options);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MATCHING_PAIR_SELECTION_H_
