// SPDX-License-Identifier: BSD-3-Clause
// Which pairs of photos are worth matching. Matching all of them takes a time
// that grows with the square of their number, and each pair that shows
// different places is a chance to be misled.

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
  // "retrieval": each photo with those most alike.
  // "sequential": the same, and photos next to each other in the given order.
  // "auto": exhaustive for up to max_exhaustive photos. Beyond, retrieval,
  // together with photos next to each other in the order of the numbers in
  // their names, where those turn out to look alike.
  std::string matcher = "auto";
  int max_exhaustive = 40;

  // How many of the photos most alike each photo is matched with.
  int neighbours = 15;

  // How many photos on each side, in the order in which they were taken, each
  // photo is matched with.
  int overlap = 5;

  Status Check() const;
};

// Two photos i < j.
using PhotoPair = std::pair<int, int>;

// How alike every two photos look.
class PhotoSimilarity {
 public:
  PhotoSimilarity() = default;
  PhotoSimilarity(const GlobalDescriptors& descriptors, ThreadPool* pool);

  int count() const { return count_; }
  float at(int i, int j) const {
    return values_[static_cast<size_t>(i) * count_ + j];
  }

  // All other photos, the most alike first, of equals the smaller index.
  std::vector<int> MostAlike(int photo) const;

 private:
  int count_ = 0;
  std::vector<float> values_;  // count_ x count_, symmetric.
};

// What was matched, for reports.
struct MatchedPairs {
  std::string strategy;  // As in PairSelection; empty when nothing was matched.
  size_t pairs = 0;
  size_t all_pairs = 0;

  bool complete() const { return pairs >= all_pairs; }
};

struct PairSelection {
  // "exhaustive", "retrieval" or "sequence and retrieval".
  std::string strategy;
  std::vector<PhotoPair> pairs;  // Ascending, each once.
};

// True if the choice depends on what the photos look like.
bool NeedsSimilarity(int num_photos, const PairSelectionOptions& options);

// The pairs of the photos with the given names to begin with. Every two photos
// are connected by a chain of these pairs. `similarity` is of the same photos;
// it may be empty unless NeedsSimilarity().
PairSelection SelectPairs(const std::vector<std::string>& names,
                          const PhotoSimilarity& similarity,
                          const PairSelectionOptions& options);

// More pairs, for when those `tried` are matched: `verified` are those of them
// whose matches fit a motion of the camera. They are for photos that too few
// others confirm, and between parts that nothing connects. Empty when there is
// neither, nothing left to try, or `similarity` is empty. Ascending.
std::vector<PhotoPair> SelectMorePairs(const PhotoSimilarity& similarity,
                                       const std::set<PhotoPair>& tried,
                                       const std::vector<PhotoPair>& verified,
                                       const PairSelectionOptions& options);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MATCHING_PAIR_SELECTION_H_
