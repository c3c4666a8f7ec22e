// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/crf/dense_crf.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "semantics/crf/unary_energies.h"
#include "tests/semantics/crf/brute_force.h"

namespace freegs::semantics {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

DenseCrfResult Infer(const ImageF& image,
                     const ImageF& unary,
                     const DenseCrfOptions& options,
                     ThreadPool& pool) {
  const auto crf = DenseCrf::Build(image, options, pool);
  EXPECT_TRUE(crf.ok()) << crf.status().message();
  auto result = crf->Infer(unary, pool);
  EXPECT_TRUE(result.ok()) << result.status().message();
  return std::move(*result);
}

void ExpectDistributions(const ImageF& probabilities) {
  for (size_t i = 0; i < probabilities.num_pixels(); ++i) {
    double sum = 0;
    for (int l = 0; l < probabilities.channels(); ++l) {
      const float p = probabilities.data()[i * probabilities.channels() + l];
      ASSERT_TRUE(p >= 0 && p <= 1) << p;
      sum += p;
    }
    ASSERT_NEAR(sum, 1, 1e-5);
  }
}

ImageF RandomUnary(int width, int height, int labels, uint64_t seed) {
  ImageF unary(width, height, labels);
  for (size_t i = 0; i < unary.size(); ++i) {
    unary.data()[i] = static_cast<float>(2 * RandomUniform(seed, 2, i));
  }
  return unary;
}

// A disc, and a thin bar and a thin slanted line away from it, on a plain
// ground; colours with noise. All lengths in parts of the width.
struct TwoColorScene {
  TwoColorScene(int width, double color_noise, bool with_thin = true)
      : image(width, width * 3 / 4, 3),
        labels(width, width * 3 / 4, 1),
        thin(width, width * 3 / 4, 1) {
    const float colors[2][3] = {{0.55f, 0.5f, 0.4f}, {0.3f, 0.35f, 0.6f}};
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < width; ++x) {
        const double u = (x + 0.5) / width;
        const double v = (y + 0.5) / width;
        const bool bar = std::abs(u - 0.7) < 0.008 && v > 0.1 && v < 0.65;
        const bool slanted = std::abs(v - 0.05 - 0.1 * u) < 0.008;
        const bool disc = std::hypot(u - 0.3, v - 0.4) < 0.18;
        thin(x, y) = with_thin && (bar || slanted) ? 1 : 0;
        labels(x, y) = thin(x, y) == 1 || disc ? 1 : 0;
        for (int c = 0; c < 3; ++c) {
          const size_t counter = 3 * (size_t{1} * y * width + x) + c;
          image(x, y, c) =
              colors[labels(x, y)][c] +
              static_cast<float>(color_noise * RandomNormal(21, 0, counter));
        }
      }
    }
  }

  // The labels with a share of them wrong.
  ImageU16 NoisyLabels(double wrong, uint64_t seed) const {
    ImageU16 noisy = labels;
    for (size_t i = 0; i < noisy.size(); ++i) {
      if (RandomUniform(seed, 0, i) < wrong) noisy.data()[i] ^= 1;
    }
    return noisy;
  }

  // The share of right labels, of all pixels or of those on thin structures.
  double Accuracy(const ImageU16& result, bool thin_only) const {
    size_t right = 0;
    size_t total = 0;
    for (size_t i = 0; i < labels.size(); ++i) {
      if (thin_only && thin.data()[i] == 0) continue;
      ++total;
      right += result.data()[i] == labels.data()[i] ? 1 : 0;
    }
    return static_cast<double>(right) / static_cast<double>(total);
  }

  ImageF image;
  ImageU16 labels;
  ImageU16 thin;
};

TEST(DenseCrfTest, CleansNoisyLabelsAndKeepsThinStructures) {
  ThreadPool pool(2);
  const TwoColorScene scene(160, 0.02);
  const ImageU16 noisy = scene.NoisyLabels(0.25, 22);
  EXPECT_LT(scene.Accuracy(noisy, false), 0.77);
  const auto unary = UnaryFromLabels(noisy, 2, 0.7);
  ASSERT_TRUE(unary.ok());
  const auto result = Infer(scene.image, *unary, {}, pool);
  ExpectDistributions(result.probabilities);
  const double all = scene.Accuracy(result.labels, false);
  const double thin = scene.Accuracy(result.labels, true);
  RecordProperty("accuracy", std::to_string(all));
  RecordProperty("accuracy_thin", std::to_string(thin));
  EXPECT_GE(all, 0.98);
  EXPECT_GE(thin, 0.95);
}

// What FreeGS has it for: a mask whose border is off.
TEST(DenseCrfTest, BordersMoveToTheImagesEdges) {
  ThreadPool pool(2);
  const TwoColorScene scene(160, 0.02, false);
  ImageU16 shifted = scene.labels;
  for (int y = 0; y < shifted.height(); ++y) {
    for (int x = 0; x < shifted.width(); ++x) {
      shifted(x, y) = scene.labels(std::max(0, x - 3), std::max(0, y - 2));
    }
  }
  const auto unary = UnaryFromLabels(shifted, 2, 0.7);
  ASSERT_TRUE(unary.ok());
  const auto result = Infer(scene.image, *unary, {}, pool);
  const double before = scene.Accuracy(shifted, false);
  const double after = scene.Accuracy(result.labels, false);
  RecordProperty("accuracy_before", std::to_string(before));
  RecordProperty("accuracy_after", std::to_string(after));
  EXPECT_LT(1 - after, 0.1 * (1 - before));
}

// The probabilities W x H x L of mean field, from its definition: messages from
// all pixels but the own, normalised by sums over all pixels.
std::vector<double> BruteForceMeanField(const ImageF& image,
                                        const ImageF& unary,
                                        const DenseCrfOptions& options) {
  const size_t points = image.num_pixels();
  const int labels = unary.channels();
  const double side = std::sqrt(static_cast<double>(points));
  std::vector<double> pairwise(points * points, 0.0);
  const auto add_kernel =
      [&](const std::vector<float>& features, int dim, double weight) {
        std::vector<double> sums(points, 0.0);
        for (size_t i = 0; i < points; ++i) {
          for (size_t j = 0; j < points; ++j) {
            sums[i] += GaussianKernel(features, dim, i, j);
          }
        }
        for (size_t i = 0; i < points; ++i) {
          for (size_t j = 0; j < points; ++j) {
            if (i == j) continue;
            pairwise[i * points + j] += weight *
                                        GaussianKernel(features, dim, i, j) /
                                        std::sqrt(sums[i] * sums[j]);
          }
        }
      };
  add_kernel(PixelFeatures(image,
                           options.appearance_position_sigma * side,
                           options.appearance_color_sigma),
             5,
             options.appearance_weight);
  add_kernel(PixelFeatures(image, options.smoothness_position_sigma * side, 0),
             2,
             options.smoothness_weight);

  std::vector<double> probabilities(points * labels, 0.0);
  for (int iteration = 0; iteration <= options.iterations; ++iteration) {
    std::vector<double> next(probabilities.size());
    for (size_t i = 0; i < points; ++i) {
      std::vector<double> logits(labels);
      for (int l = 0; l < labels; ++l) {
        logits[l] = -double{unary.data()[i * labels + l]};
        for (size_t j = 0; j < points && iteration > 0; ++j) {
          logits[l] += pairwise[i * points + j] * probabilities[j * labels + l];
        }
      }
      const double largest = *std::max_element(logits.begin(), logits.end());
      double sum = 0;
      for (const double logit : logits) sum += std::exp(logit - largest);
      for (int l = 0; l < labels; ++l) {
        next[i * labels + l] = std::exp(logits[l] - largest) / sum;
      }
    }
    probabilities.swap(next);
  }
  return probabilities;
}

TEST(DenseCrfTest, AgreesWithTheDefinition) {
  ThreadPool pool(2);
  constexpr int kLabels = 3;
  const DenseCrfOptions options = {.appearance_weight = 3,
                                   .appearance_position_sigma = 0.3,
                                   .appearance_color_sigma = 0.1,
                                   .smoothness_weight = 2,
                                   .smoothness_position_sigma = 0.06,
                                   .iterations = 5};
  const ImageF image = SmoothImage(28, 21, 0.02, 23);
  const ImageF unary = RandomUnary(28, 21, kLabels, 24);
  const auto result = Infer(image, unary, options, pool);
  ExpectDistributions(result.probabilities);
  const auto expected = BruteForceMeanField(image, unary, options);
  double mean = 0;
  double largest = 0;
  size_t same = 0;
  for (size_t i = 0; i < image.num_pixels(); ++i) {
    const double* row = expected.data() + i * kLabels;
    const auto best = std::max_element(row, row + kLabels) - row;
    same += result.labels.data()[i] == best ? 1 : 0;
    for (int l = 0; l < kLabels; ++l) {
      const double difference =
          std::abs(result.probabilities.data()[i * kLabels + l] - row[l]);
      mean += difference / static_cast<double>(expected.size());
      largest = std::max(largest, difference);
    }
  }
  const double agreement =
      static_cast<double>(same) / static_cast<double>(image.num_pixels());
  RecordProperty("mean_error", std::to_string(mean));
  RecordProperty("largest_error", std::to_string(largest));
  RecordProperty("agreement", std::to_string(agreement));
  EXPECT_LT(mean, 0.02);
  EXPECT_LT(largest, 0.1);
  EXPECT_GT(agreement, 0.95);
}

TEST(DenseCrfTest, TheSamePictureHasTheSameLabelsAtAnyResolution) {
  ThreadPool pool(2);
  const TwoColorScene small(96, 0);
  const TwoColorScene large(192, 0);
  double shares[2];
  for (const bool is_large : {false, true}) {
    const TwoColorScene& scene = is_large ? large : small;
    // The left quarter says disc, the right one ground; colour decides.
    ImageU16 known(scene.image.width(), scene.image.height(), 1, kUnknownLabel);
    for (int y = 0; y < known.height(); ++y) {
      for (int x = 0; x < known.width(); ++x) {
        const double u = (x + 0.5) / known.width();
        const double v = (y + 0.5) / known.width();
        if (std::hypot(u - 0.3, v - 0.4) < 0.1) known(x, y) = 1;
        if (u > 0.75 && v > 0.2) known(x, y) = 0;
      }
    }
    const auto unary = UnaryFromLabels(known, 2, 0.9);
    ASSERT_TRUE(unary.ok());
    const auto result = Infer(scene.image, *unary, {}, pool);
    size_t marked = 0;
    for (size_t i = 0; i < result.labels.size(); ++i) {
      marked += result.labels.data()[i];
    }
    shares[is_large ? 1 : 0] =
        static_cast<double>(marked) / static_cast<double>(result.labels.size());
  }
  RecordProperty("share_small", std::to_string(shares[0]));
  RecordProperty("share_large", std::to_string(shares[1]));
  EXPECT_NEAR(shares[0] / shares[1], 1, 0.05);
}

TEST(DenseCrfTest, WithoutIterationsOrWeightsItIsASoftmax) {
  ThreadPool pool(2);
  const ImageF image = SmoothImage(20, 15, 0.1, 25);
  const ImageF unary = RandomUnary(20, 15, 4, 26);
  for (const DenseCrfOptions& options :
       {DenseCrfOptions{.iterations = 0},
        DenseCrfOptions{.appearance_weight = 0, .smoothness_weight = 0}}) {
    const auto result = Infer(image, unary, options, pool);
    for (size_t i = 0; i < unary.num_pixels(); ++i) {
      double sum = 0;
      for (int l = 0; l < 4; ++l) sum += std::exp(-unary.data()[4 * i + l]);
      for (int l = 0; l < 4; ++l) {
        ASSERT_NEAR(result.probabilities.data()[4 * i + l],
                    std::exp(-unary.data()[4 * i + l]) / sum,
                    1e-6);
      }
    }
  }
}

TEST(DenseCrfTest, ThreadsDoNotMatter) {
  const ImageF image = SmoothImage(120, 90, 0.03, 27);
  const ImageF unary = RandomUnary(120, 90, 5, 28);
  ThreadPool one(1);
  const auto expected = Infer(image, unary, {}, one);
  for (const int threads : {2, 3, 8}) {
    ThreadPool pool(threads);
    const auto result = Infer(image, unary, {}, pool);
    EXPECT_EQ(std::memcmp(result.probabilities.data(),
                          expected.probabilities.data(),
                          sizeof(float) * unary.size()),
              0);
    EXPECT_EQ(std::memcmp(result.labels.data(),
                          expected.labels.data(),
                          sizeof(uint16_t) * unary.num_pixels()),
              0);
  }
}

TEST(DenseCrfTest, OnePixel) {
  ThreadPool pool(2);
  ImageF unary(1, 1, 3);
  unary(0, 0, 1) = -2;
  const auto result = Infer(ImageF(1, 1, 3, 0.5f), unary, {}, pool);
  ExpectDistributions(result.probabilities);
  EXPECT_EQ(result.labels(0, 0), 1);
}

TEST(DenseCrfTest, OneLabel) {
  ThreadPool pool(2);
  const ImageF unary = RandomUnary(9, 7, 1, 29);
  const auto result = Infer(SmoothImage(9, 7, 0.1, 30), unary, {}, pool);
  for (size_t i = 0; i < unary.size(); ++i) {
    EXPECT_EQ(result.probabilities.data()[i], 1);
    EXPECT_EQ(result.labels.data()[i], 0);
  }
}

// Nothing but position tells pixels apart: the majority around wins.
TEST(DenseCrfTest, ConstantImage) {
  ThreadPool pool(2);
  ImageU16 labels(40, 30, 1, 2);
  for (int x = 0; x < 40; x += 7) labels(x, 15) = 0;
  const auto unary = UnaryFromLabels(labels, 3, 0.6);
  ASSERT_TRUE(unary.ok());
  const auto result = Infer(ImageF(40, 30, 3, 0.25f), *unary, {}, pool);
  ExpectDistributions(result.probabilities);
  for (size_t i = 0; i < labels.size(); ++i) {
    EXPECT_EQ(result.labels.data()[i], 2);
  }
}

TEST(DenseCrfTest, InfiniteEnergiesForbidLabels) {
  ThreadPool pool(2);
  ImageF unary = RandomUnary(30, 20, 3, 31);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 30; ++x) {
      if (x < 10) unary(x, y, 0) = kInfinity;
      if (x < 5) unary(x, y, 2) = kInfinity;
    }
  }
  const auto result = Infer(ImageF(30, 20, 3, 0.5f), unary, {}, pool);
  ExpectDistributions(result.probabilities);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 10; ++x) EXPECT_EQ(result.probabilities(x, y, 0), 0);
    for (int x = 0; x < 5; ++x) EXPECT_EQ(result.probabilities(x, y, 1), 1);
  }
}

TEST(DenseCrfTest, ExtremeInputHasNoNaN) {
  ThreadPool pool(2);
  constexpr float kHuge = std::numeric_limits<float>::max();
  ImageF unary(8, 6, 3);
  for (size_t i = 0; i < unary.size(); ++i) {
    const float values[] = {kHuge, -kHuge, 0, 1e-30f, kInfinity, -1e20f, 88};
    unary.data()[i] = values[i % 7];
  }
  // Colours as unlike as the lattice allows.
  ImageF image(8, 6, 3);
  for (size_t i = 0; i < image.size(); ++i) {
    image.data()[i] = static_cast<float>(RandomUniform(32, 0, i) * 4e4);
  }
  const DenseCrfOptions strong = {
      .appearance_weight = 1000, .smoothness_weight = 1000, .iterations = 30};
  ExpectDistributions(Infer(image, unary, strong, pool).probabilities);
  const DenseCrfOptions wide = {.appearance_position_sigma = 100,
                                .appearance_color_sigma = 100,
                                .smoothness_position_sigma = 100};
  ExpectDistributions(Infer(image, unary, wide, pool).probabilities);
}

// Elongated images, many labels: more than one block of channels.
TEST(DenseCrfTest, OddShapes) {
  ThreadPool pool(2);
  for (const auto& [width, height] : {std::pair(5000, 1), {1, 300}, {2, 2}}) {
    const ImageF unary = RandomUnary(width, height, 45, 33);
    const auto result =
        Infer(SmoothImage(width, height, 0.05, 34), unary, {}, pool);
    ExpectDistributions(result.probabilities);
  }
}

TEST(DenseCrfTest, RefusesWhatMakesNoSense) {
  ThreadPool pool(1);
  constexpr auto kRefused = StatusCode::kInvalidArgument;
  const ImageF image(6, 4, 3, 0.5f);
  const auto build = [&](const ImageF& guide, const DenseCrfOptions& options) {
    return DenseCrf::Build(guide, options, pool).status().code();
  };
  EXPECT_EQ(build(ImageF(), {}), kRefused);
  EXPECT_EQ(build(ImageF(6, 4, 1), {}), kRefused);
  for (const float bad : {std::nanf(""), kInfinity, 1e6f}) {
    ImageF broken = image;
    broken(3, 2, 1) = bad;
    EXPECT_EQ(build(broken, {}), kRefused);
  }
  const double nan = std::nan("");
  for (const DenseCrfOptions& options :
       {DenseCrfOptions{.appearance_weight = -1},
        DenseCrfOptions{.appearance_position_sigma = 0},
        DenseCrfOptions{.appearance_color_sigma = nan},
        DenseCrfOptions{.smoothness_weight = nan},
        DenseCrfOptions{.smoothness_position_sigma = HUGE_VAL},
        DenseCrfOptions{.iterations = -1},
        DenseCrfOptions{.iterations = 1001}}) {
    EXPECT_EQ(options.Check().code(), kRefused);
    EXPECT_EQ(build(image, options), kRefused);
  }

  const auto crf = DenseCrf::Build(image, {}, pool);
  ASSERT_TRUE(crf.ok());
  const auto infer = [&](const ImageF& unary) {
    return crf->Infer(unary, pool).status().code();
  };
  EXPECT_EQ(infer(ImageF()), kRefused);
  EXPECT_EQ(infer(ImageF(4, 6, 2)), kRefused);
  EXPECT_EQ(infer(ImageF(6, 4, 0)), kRefused);
  EXPECT_EQ(infer(ImageF(6, 4, 65536)), kRefused);
  for (const float bad : {std::nanf(""), -kInfinity}) {
    ImageF broken(6, 4, 2);
    broken(1, 3, 1) = bad;
    EXPECT_EQ(infer(broken), kRefused);
  }
  ImageF without(6, 4, 2);
  without(1, 3, 0) = without(1, 3, 1) = kInfinity;
  EXPECT_EQ(infer(without), kRefused);
}

}  // namespace
}  // namespace freegs::semantics
