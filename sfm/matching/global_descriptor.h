// SPDX-License-Identifier: BSD-3-Clause
// How alike two photos look as a whole, without matching their features: one
// vector per photo, made from its SIFT descriptors.

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
  // Features of a photo that are used, the largest ones: those survive a change
  // of distance, and there are fewer accidental ones among them.
  int max_features = 1000;

  // Words of the vocabulary: cluster centres of the scene's own descriptors.
  int words = 128;

  // Descriptors, of all photos together, that the vocabulary is learned from,
  // and rounds of doing so.
  int max_training = 10000;
  int iterations = 5;

  uint64_t seed = 0;

  Status Check() const;
};

// The features of one photo.
struct PhotoFeatures {
  const SiftDescriptors* descriptors = nullptr;

  // The size of each in its image. Empty if unknown: features are then taken
  // evenly from the list.
  std::vector<float> scales;
};

// One row of `size` numbers per photo, of length 1, or all zero for a photo
// without features.
struct GlobalDescriptors {
  size_t count = 0;
  size_t size = 0;
  std::vector<float> values;

  const float* row(size_t i) const { return values.data() + i * size; }

  // The cosine of the angle between two photos' vectors: 1 for equal photos;
  // about 0 for unrelated ones, if there are dozens of photos (the vectors of a
  // scene sum to about 0, so of two photos one is the other's opposite); 0 when
  // one has no features.
  float Similarity(size_t i, size_t j) const;
};

// VLAD: the differences between descriptors and their nearest word, summed per
// word (Jegou, Douze, Schmid and Perez, "Aggregating local descriptors into a
// compact image representation", CVPR 2010), each word's sum scaled to length
// 1, so that none outweighs the others (Arandjelovic and Zisserman, "All about
// VLAD", CVPR 2013); then the square root of every number, keeping its sign,
// and length 1 for the whole.
//
// SIFT descriptors are taken as COLMAP stores them, which is after the square
// root that suits their kind of histogram (RootSIFT). The result is the same
// whatever the number of threads. options must pass Check().
GlobalDescriptors DescribePhotos(const std::vector<PhotoFeatures>& photos,
                                 const GlobalDescriptorOptions& options,
                                 ThreadPool* pool);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MATCHING_GLOBAL_DESCRIPTOR_H_
