// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/matching/global_descriptor.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/random.h"

namespace freegs::sfm {
namespace {

constexpr size_t kDims = kSiftDimensions;

// Indices of the features that are used, at most `limit`, ascending.
std::vector<size_t> ChooseFeatures(const PhotoFeatures& photo, size_t limit) {
  const size_t count = photo.descriptors->count();
  const size_t kept = std::min(count, limit);
  std::vector<size_t> chosen(kept);
  if (photo.scales.size() != count) {
    for (size_t i = 0; i < kept; ++i) chosen[i] = i * count / kept;
    return chosen;
  }
  std::vector<size_t> order(count);
  std::iota(order.begin(), order.end(), size_t{0});
  // The largest; of equals the later, as COLMAP lists small ones first.
  std::nth_element(order.begin(),
                   order.begin() + kept,
                   order.end(),
                   [&photo](size_t a, size_t b) {
                     return std::pair(photo.scales[a], a) >
                            std::pair(photo.scales[b], b);
                   });
  std::copy_n(order.begin(), kept, chosen.begin());
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

// The words, dimension by dimension: a descriptor's products with all of them
// are sums of rows, which the compiler turns into vector instructions without
// changing the order of any sum.
class Vocabulary {
 public:
  explicit Vocabulary(size_t words)
      : words_(words), values_(words * kDims), offsets_(words) {}

  size_t words() const { return words_; }
  float value(size_t word, size_t k) const {
    return values_[k * words_ + word];
  }
  void Set(size_t word, size_t k, float value) {
    values_[k * words_ + word] = value;
  }

  // To be called when words have changed.
  void Prepare() {
    std::fill(offsets_.begin(), offsets_.end(), 0.0f);
    for (size_t k = 0; k < kDims; ++k) {
      for (size_t w = 0; w < words_; ++w) {
        const float v = values_[k * words_ + w];
        offsets_[w] -= 0.5f * v * v;
      }
    }
  }

  // The word at the smallest distance; the first of equals.
  size_t Nearest(const uint8_t* descriptor, std::vector<float>* scratch) const {
    scratch->assign(offsets_.begin(), offsets_.end());
    float* const scores = scratch->data();
    for (size_t k = 0; k < kDims; ++k) {
      if (descriptor[k] == 0) continue;
      const float x = descriptor[k];
      const float* const row = values_.data() + k * words_;
      for (size_t w = 0; w < words_; ++w) scores[w] += x * row[w];
    }
    return std::max_element(scores, scores + words_) - scores;
  }

 private:
  size_t words_;
  std::vector<float> values_;
  std::vector<float> offsets_;  // Minus half the squared length of each.
};

using Sample = std::vector<const uint8_t*>;

// The used descriptors of a photo.
Sample UsedDescriptors(const PhotoFeatures& photo, int max_features) {
  Sample used;
  for (const size_t i : ChooseFeatures(photo, max_features)) {
    used.push_back(photo.descriptors->values.data() + i * kDims);
  }
  return used;
}

// Returns at most max_training of the features of all photos, in random order.
Sample TrainingSample(const std::vector<Sample>& photos,
                      const GlobalDescriptorOptions& options) {
  Sample all;
  for (const Sample& photo : photos) {
    all.insert(all.end(), photo.begin(), photo.end());
  }
  const size_t kept = std::min<size_t>(all.size(), options.max_training);
  // The first places of a random order.
  for (size_t i = 0; i < kept; ++i) {
    const size_t other =
        i + RandomIndex(options.seed, /*stream=*/0, i, all.size() - i);
    std::swap(all[i], all[other]);
  }
  all.resize(kept);
  return all;
}

// k-means (Lloyd's iterations) from the first of the sample. Sums are of
// integers, hence the same in any order. Words that nothing is nearest to stay.
Vocabulary LearnVocabulary(const Sample& sample,
                           const GlobalDescriptorOptions& options,
                           ThreadPool& pool) {
  constexpr int64_t kGrain = 256;
  Vocabulary words(
      std::clamp<size_t>(sample.size(), 1, static_cast<size_t>(options.words)));
  if (sample.empty()) return words;
  for (size_t w = 0; w < words.words(); ++w) {
    const uint8_t* const start = sample[w];
    for (size_t k = 0; k < kDims; ++k) words.Set(w, k, start[k]);
  }
  std::vector<uint32_t> nearest(sample.size());
  for (int round = 0; round < options.iterations; ++round) {
    words.Prepare();
    pool.ParallelFor(0,
                     static_cast<int64_t>(sample.size()),
                     kGrain,
                     [&](int64_t first, int64_t last, int) {
                       std::vector<float> scratch;
                       for (int64_t i = first; i < last; ++i) {
                         nearest[i] = static_cast<uint32_t>(
                             words.Nearest(sample[i], &scratch));
                       }
                     });
    std::vector<int64_t> sums(words.words() * kDims);
    std::vector<int64_t> counts(words.words());
    for (size_t i = 0; i < sample.size(); ++i) {
      ++counts[nearest[i]];
      int64_t* const sum = sums.data() + nearest[i] * kDims;
      for (size_t k = 0; k < kDims; ++k) sum[k] += sample[i][k];
    }
    for (size_t w = 0; w < words.words(); ++w) {
      if (counts[w] == 0) continue;
      for (size_t k = 0; k < kDims; ++k) {
        words.Set(w,
                  k,
                  static_cast<float>(static_cast<double>(sums[w * kDims + k]) /
                                     static_cast<double>(counts[w])));
      }
    }
  }
  words.Prepare();
  return words;
}

// Scales to length 1, unless all are 0.
void Normalise(float* values, size_t count) {
  double squared = 0;
  for (size_t i = 0; i < count; ++i) squared += double{values[i]} * values[i];
  if (squared <= 0) return;
  const double scale = 1 / std::sqrt(squared);
  for (size_t i = 0; i < count; ++i) {
    values[i] = static_cast<float>(values[i] * scale);
  }
}

// The vector of one photo into words * kDims numbers.
void Describe(const Sample& photo, const Vocabulary& words, float* row) {
  std::vector<float> scratch;
  for (const uint8_t* const descriptor : photo) {
    const size_t w = words.Nearest(descriptor, &scratch);
    for (size_t k = 0; k < kDims; ++k) {
      row[w * kDims + k] += descriptor[k] - words.value(w, k);
    }
  }
  for (size_t w = 0; w < words.words(); ++w) Normalise(row + w * kDims, kDims);
  const size_t size = words.words() * kDims;
  for (size_t i = 0; i < size; ++i) {
    row[i] = std::copysign(std::sqrt(std::abs(row[i])), row[i]);
  }
  Normalise(row, size);
}

}  // namespace

Status GlobalDescriptorOptions::Check() const {
  if (max_features < 1 || words < 1 || max_training < 1 || iterations < 0) {
    return InvalidArgumentError(
        "global descriptors need at least one feature, word and training "
        "descriptor");
  }
  return {};
}

float GlobalDescriptors::Similarity(size_t i, size_t j) const {
  // Eight sums in a fixed order, so that the compiler may use vectors.
  constexpr size_t kSums = 8;
  const float* const a = row(i);
  const float* const b = row(j);
  float sums[kSums] = {};
  for (size_t k = 0; k + kSums <= size; k += kSums) {
    for (size_t s = 0; s < kSums; ++s) sums[s] += a[k + s] * b[k + s];
  }
  float sum = 0;
  for (const float part : sums) sum += part;
  return sum;
}

GlobalDescriptors DescribePhotos(const std::vector<PhotoFeatures>& photos,
                                 const GlobalDescriptorOptions& options,
                                 ThreadPool& pool) {
  std::vector<Sample> used;
  used.reserve(photos.size());
  for (const PhotoFeatures& photo : photos) {
    used.push_back(UsedDescriptors(photo, options.max_features));
  }
  const Vocabulary words =
      LearnVocabulary(TrainingSample(used, options), options, pool);
  GlobalDescriptors result;
  result.count = photos.size();
  result.size = words.words() * kDims;
  result.values.resize(result.count * result.size);
  pool.ParallelFor(
      0,
      static_cast<int64_t>(photos.size()),
      1,
      [&](int64_t first, int64_t last, int) {
        for (int64_t i = first; i < last; ++i) {
          Describe(used[i], words, result.values.data() + i * result.size);
        }
      });
  return result;
}

}  // namespace freegs::sfm
