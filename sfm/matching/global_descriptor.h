// SPDX-License-Identifier: BSD-3-Clause
// Describes each photo as a whole by one vector, made from its SIFT
// descriptors. The vectors tell how alike two photos look without matching
// their features.

#ifndef FREEGS_SFM_MATCHING_GLOBAL_DESCRIPTOR_H_
#define FREEGS_SFM_MATCHING_GLOBAL_DESCRIPTOR_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"
#include "sfm/matching/descriptor_matching.h"

namespace freegs::sfm {

struct GlobalDescriptorOptions {
  // How many features of a photo are used. These are its largest ones, because
  // they are found again from other distances and fewer of them are accidental.
  int max_features = 1000;

  // Number of words of the vocabulary, which are cluster centres of the scene's
  // own descriptors.
  int words = 128;

  // How many descriptors, of all photos together, the vocabulary is learned
  // from, and how many rounds of clustering there are.
  int max_training = 10000;
  int iterations = 5;

  uint64_t seed = 0;

  Status Check() const;
};

// The features of one photo.
struct PhotoFeatures {
  const SiftDescriptors* descriptors = nullptr;

  // The size of each feature in its image. Empty if it is not known; features
  // are then taken evenly from the list.
  std::vector<float> scales;
};

// A row of `size` numbers for each photo. As a vector it has length 1, or is
// zero for a photo without features.
struct GlobalDescriptors {
  size_t count = 0;
  size_t size = 0;
  std::vector<float> values;

  const float* row(size_t i) const { return values.data() + i * size; }

  // The cosine of the angle between the vectors of two photos. It is 1 for
  // equal photos and 0 when one has no features. For unrelated photos it is
  // about 0 if there are dozens of photos; with few it is lower, because the
  // vectors of a scene sum to about 0.
  float Similarity(size_t i, size_t j) const;
};

// Computes VLAD vectors (Jegou, Douze, Schmid and Perez, "Aggregating local
// descriptors into a compact image representation", CVPR 2010): for each word
// of the vocabulary, the sum of the differences between the word and those
// descriptors to which it is the nearest. Each sum is scaled to length 1, so
// that none outweighs the others (Arandjelovic and Zisserman, "All about VLAD",
// CVPR 2013). Then each number is replaced by its square root with the same
// sign, and the whole vector is scaled to length 1.
//
// The descriptors are those in COLMAP's database, which are RootSIFT already.
// The result does not depend on the number of threads. `options` must pass
// Check().
GlobalDescriptors DescribePhotos(const std::vector<PhotoFeatures>& photos,
                                 const GlobalDescriptorOptions& options,
                                 ThreadPool& pool);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MATCHING_GLOBAL_DESCRIPTOR_H_
