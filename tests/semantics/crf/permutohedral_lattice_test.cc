// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/crf/permutohedral_lattice.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/semantics/crf/brute_force.h"

namespace freegs::semantics {
namespace {

std::vector<float> RandomValues(size_t count, uint64_t seed) {
  std::vector<float> values(count);
  for (size_t i = 0; i < count; ++i) {
    values[i] = static_cast<float>(RandomUniform(seed, 0, i));
  }
  return values;
}

std::vector<float> RandomFeatures(size_t points,
                                  int dim,
                                  double spread,
                                  uint64_t seed) {
  std::vector<float> features(points * dim);
  for (size_t i = 0; i < features.size(); ++i) {
    features[i] = static_cast<float>(spread * RandomNormal(seed, 1, i));
  }
  return features;
}

PermutohedralLattice BuildLattice(std::span<const float> features,
                                  int dim,
                                  ThreadPool& pool) {
  auto lattice = PermutohedralLattice::Build(features, dim, pool);
  EXPECT_TRUE(lattice.ok()) << lattice.status().message();
  return std::move(*lattice);
}

std::vector<float> Filter(const PermutohedralLattice& lattice,
                          std::span<const float> values,
                          int channels,
                          ThreadPool& pool) {
  std::vector<float> result(values.size(), 0.0f);
  LatticeBuffers buffers;
  EXPECT_TRUE(
      lattice.AddFiltered(values, channels, 1, pool, &buffers, result).ok());
  return result;
}

double Dot(const std::vector<float>& a, const std::vector<float>& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

// How far the lattice is from the definition: of sums K 1, relative; and of
// means K v / K 1 of a step, a texture and noise in [0, 1].
struct FilterError {
  double sum_rms = 0;
  double sum_bias = 0;
  double mean_rms = 0;
  double mean_max = 0;
};

FilterError MeasureError(const std::vector<float>& features,
                         int dim,
                         int width,
                         ThreadPool& pool) {
  constexpr int kChannels = 4;
  const size_t points = features.size() / dim;
  std::vector<float> values(points * kChannels);
  for (size_t i = 0; i < points; ++i) {
    const auto x = static_cast<int>(i % width);
    const auto y = static_cast<int>(i / width);
    float* row = values.data() + i * kChannels;
    row[0] = 1;
    row[1] = 2 * x > width ? 1.0f : 0.0f;
    row[2] = (x / 3 + y / 3) % 2 == 0 ? 1.0f : 0.0f;
    row[3] = static_cast<float>(RandomUniform(5, 0, i));
  }
  const PermutohedralLattice lattice = BuildLattice(features, dim, pool);
  const auto filtered = Filter(lattice, values, kChannels, pool);
  const auto exact = BruteForceFilter(features, dim, values, kChannels);
  FilterError error;
  for (size_t i = 0; i < points; ++i) {
    const float* row = filtered.data() + i * kChannels;
    const double* truth = exact.data() + i * kChannels;
    const double relative = row[0] / truth[0] - 1;
    error.sum_rms += relative * relative / points;
    error.sum_bias += relative / points;
    for (int c = 1; c < kChannels; ++c) {
      const double difference = row[c] / row[0] - truth[c] / truth[0];
      error.mean_rms += difference * difference / (points * (kChannels - 1));
      error.mean_max = std::max(error.mean_max, std::abs(difference));
    }
  }
  error.sum_rms = std::sqrt(error.sum_rms);
  error.mean_rms = std::sqrt(error.mean_rms);
  ::testing::Test::RecordProperty("sum_rms", std::to_string(error.sum_rms));
  ::testing::Test::RecordProperty("sum_bias", std::to_string(error.sum_bias));
  ::testing::Test::RecordProperty("mean_rms", std::to_string(error.mean_rms));
  ::testing::Test::RecordProperty("mean_max", std::to_string(error.mean_max));
  return error;
}

TEST(PermutohedralLatticeTest, ErrorInTwoDimensions) {
  ThreadPool pool(2);
  const ImageF image(40, 30, 3);
  const FilterError error =
      MeasureError(PixelFeatures(image, 3, 0), 2, 40, pool);
  EXPECT_LT(error.sum_rms, 0.05);
  EXPECT_LT(error.mean_rms, 0.05);
  EXPECT_LT(error.mean_max, 0.2);
}

TEST(PermutohedralLatticeTest, ErrorInFiveDimensions) {
  ThreadPool pool(2);
  const ImageF image = SmoothImage(40, 30, 0.02, 1);
  const FilterError error =
      MeasureError(PixelFeatures(image, 8, 0.08), 5, 40, pool);
  EXPECT_LT(error.sum_rms, 0.3);
  EXPECT_LT(error.mean_rms, 0.05);
  EXPECT_LT(error.mean_max, 0.2);
}

// Hardly two pixels within a standard deviation of each other: the lattice's
// worst case, since most neighbours of vertices are missing.
TEST(PermutohedralLatticeTest, ErrorInFiveDimensionsWhereSparse) {
  ThreadPool pool(2);
  const ImageF image = SmoothImage(40, 30, 0.2, 1);
  const FilterError error =
      MeasureError(PixelFeatures(image, 8, 0.08), 5, 40, pool);
  EXPECT_LT(error.sum_rms, 0.8);
  EXPECT_LT(error.mean_rms, 0.3);
}

TEST(PermutohedralLatticeTest, ConstantsStayConstant) {
  ThreadPool pool(2);
  for (const int dim : {1, 2, 5, 9}) {
    const auto features = RandomFeatures(700, dim, 2, dim);
    const auto lattice = BuildLattice(features, dim, pool);
    std::vector<float> values(700 * 2);
    for (size_t i = 0; i < 700; ++i) {
      values[2 * i] = 1;
      values[2 * i + 1] = -3.5f;
    }
    const auto filtered = Filter(lattice, values, 2, pool);
    for (size_t i = 0; i < 700; ++i) {
      ASSERT_GT(filtered[2 * i], 0);
      ASSERT_NEAR(filtered[2 * i + 1] / filtered[2 * i], -3.5, 2e-5);
    }
  }
}

// Far from borders, a plane densely sampled sums to a Gaussian's integral.
TEST(PermutohedralLatticeTest, SumsAreThoseOfAGaussianOfHeightOne) {
  ThreadPool pool(2);
  const double sigma = 4;
  const auto features = PixelFeatures(ImageF(64, 64, 3), sigma, 0);
  const auto lattice = BuildLattice(features, 2, pool);
  const std::vector<float> ones(64 * 64, 1.0f);
  const auto sums = Filter(lattice, ones, 1, pool);
  const double integral = 2 * std::numbers::pi * sigma * sigma;
  for (int y = 26; y < 38; ++y) {
    for (int x = 26; x < 38; ++x) {
      EXPECT_NEAR(sums[y * 64 + x] / integral, 1, 0.02);
    }
  }
}

// Blurs along different axes do not commute where vertices are missing.
TEST(PermutohedralLatticeTest, IsNearlySymmetric) {
  ThreadPool pool(2);
  for (const int dim : {2, 5}) {
    const auto features = RandomFeatures(1500, dim, 1.5, 7);
    const auto lattice = BuildLattice(features, dim, pool);
    const auto x = RandomValues(1500, 8);
    const auto y = RandomValues(1500, 9);
    const double forward = Dot(Filter(lattice, x, 1, pool), y);
    const double swapped = Dot(x, Filter(lattice, y, 1, pool));
    RecordProperty("asymmetry_" + std::to_string(dim),
                   std::to_string(forward / swapped - 1));
    EXPECT_NEAR(forward / swapped, 1, 0.01);
  }
}

TEST(PermutohedralLatticeTest, WithAllNeighboursPresentTheFilterIsSymmetric) {
  ThreadPool pool(2);
  // Samples so dense that no vertex is missing but at the border, and values
  // that vanish there.
  const ImageF image(48, 48, 3);
  const auto lattice = BuildLattice(PixelFeatures(image, 2, 0), 2, pool);
  std::vector<float> x(48 * 48, 0.0f);
  std::vector<float> y = x;
  for (int v = 16; v < 32; ++v) {
    for (int u = 16; u < 32; ++u) {
      x[v * 48 + u] = static_cast<float>(RandomUniform(1, v, u));
      y[v * 48 + u] = static_cast<float>(RandomUniform(2, v, u));
    }
  }
  EXPECT_NEAR(
      Dot(Filter(lattice, x, 1, pool), y) / Dot(x, Filter(lattice, y, 1, pool)),
      1,
      1e-6);
}

TEST(PermutohedralLatticeTest, NormalisedFilterMapsRootsOfSumsToThemselves) {
  ThreadPool pool(2);
  const auto features = PixelFeatures(SmoothImage(30, 20, 0.02, 3), 5, 0.1);
  auto lattice = BuildLattice(features, 5, pool);
  const std::vector<float> ones(600, 1.0f);
  std::vector<float> roots = Filter(lattice, ones, 1, pool);
  for (float& root : roots) root = std::sqrt(root);
  lattice.NormalizeSymmetrically(pool);
  const auto filtered = Filter(lattice, roots, 1, pool);
  for (size_t i = 0; i < 600; ++i) ASSERT_NEAR(filtered[i] / roots[i], 1, 1e-5);
}

// An indicator per point gives the whole matrix K.
TEST(PermutohedralLatticeTest, SelfResponseIsABoundFromBelow) {
  ThreadPool pool(2);
  constexpr int kPoints = 60;
  for (const int dim : {1, 2, 5}) {
    for (const double spread : {0.3, 3.0, 100.0}) {
      auto lattice =
          BuildLattice(RandomFeatures(kPoints, dim, spread, 11), dim, pool);
      for (const bool normalized : {false, true}) {
        if (normalized) lattice.NormalizeSymmetrically(pool);
        std::vector<float> identity(kPoints * kPoints, 0.0f);
        for (int i = 0; i < kPoints; ++i) identity[i * kPoints + i] = 1;
        const auto matrix = Filter(lattice, identity, kPoints, pool);
        double ratio = 0;
        for (int i = 0; i < kPoints; ++i) {
          const double own = matrix[i * kPoints + i];
          EXPECT_GT(own, 0);
          EXPECT_LE(lattice.SelfResponse(i), own * (1 + 1e-5));
          ratio += lattice.SelfResponse(i) / own / kPoints;
        }
        for (const float entry : matrix) ASSERT_GE(entry, 0);
        EXPECT_GT(ratio, 0.5);
      }
    }
  }
}

TEST(PermutohedralLatticeTest, ThreadsDoNotMatter) {
  const ImageF image = SmoothImage(150, 110, 0.03, 12);  // Five chunks.
  const auto features = PixelFeatures(image, 12, 0.08);
  const auto values = RandomValues(image.num_pixels() * 7, 13);
  ThreadPool one(1);
  const auto expected_lattice = BuildLattice(features, 5, one);
  const auto expected = Filter(expected_lattice, values, 7, one);
  for (const int threads : {2, 3, 8}) {
    ThreadPool pool(threads);
    const auto lattice = BuildLattice(features, 5, pool);
    EXPECT_EQ(lattice.num_vertices(), expected_lattice.num_vertices());
    EXPECT_EQ(Filter(lattice, values, 7, pool), expected);
  }
}

TEST(PermutohedralLatticeTest, ChannelsDoNotMixAndGainsAdd) {
  ThreadPool pool(2);
  constexpr int kChannels = 37;  // More than one block, and a rest.
  const auto features = RandomFeatures(800, 3, 2, 14);
  const auto lattice = BuildLattice(features, 3, pool);
  const auto values = RandomValues(800 * kChannels, 15);
  const auto together = Filter(lattice, values, kChannels, pool);
  LatticeBuffers buffers;
  for (const int c : {0, 31, 32, 36}) {
    std::vector<float> single(800);
    for (size_t i = 0; i < 800; ++i) single[i] = values[i * kChannels + c];
    std::vector<float> result(800, 1.0f);
    ASSERT_TRUE(
        lattice.AddFiltered(single, 1, -0.5f, pool, &buffers, result).ok());
    for (size_t i = 0; i < 800; ++i) {
      const float expected = 1 - 0.5f * together[i * kChannels + c];
      ASSERT_NEAR(result[i], expected, 1e-5 * (1 + std::abs(expected)));
    }
  }
}

TEST(PermutohedralLatticeTest, FewVerticesWherePointsAreTheSame) {
  ThreadPool pool(2);
  const std::vector<float> same(5 * 6000, 0.3f);
  const auto lattice = BuildLattice(same, 5, pool);
  EXPECT_EQ(lattice.num_points(), 6000u);
  EXPECT_EQ(lattice.num_vertices(), 6u);
  const auto scattered = RandomFeatures(300, 5, 1000, 16);
  EXPECT_LE(BuildLattice(scattered, 5, pool).num_vertices(), 300u * 6);
}

TEST(PermutohedralLatticeTest, ASinglePoint) {
  ThreadPool pool(1);
  const float feature[] = {12.5f, -3.25f};
  const auto lattice = BuildLattice(feature, 2, pool);
  const float value[] = {2};
  const auto filtered = Filter(lattice, value, 1, pool);
  // exp(0), as well as the lattice can tell.
  EXPECT_GT(filtered[0] / 2, 0.4);
  EXPECT_LT(filtered[0] / 2, 2.5);
}

TEST(PermutohedralLatticeTest, RefusesWhatMakesNoSense) {
  ThreadPool pool(1);
  constexpr auto kRefused = StatusCode::kInvalidArgument;
  const auto code = [&](const std::vector<float>& features, int dim) {
    return PermutohedralLattice::Build(features, dim, pool).status().code();
  };
  EXPECT_EQ(code({}, 2), kRefused);
  EXPECT_EQ(code({1, 2, 3}, 2), kRefused);
  EXPECT_EQ(code({1}, 0), kRefused);
  EXPECT_EQ(code(std::vector<float>(17), 17), kRefused);
  for (const float bad : {std::nanf(""), HUGE_VALF, -2e6f}) {
    EXPECT_EQ(code({0, bad}, 2), kRefused);
  }
  // Too many: refused before anything of the span is read.
  const float nothing = 0;
  EXPECT_EQ(PermutohedralLattice::Build(
                std::span<const float>(&nothing, size_t{5} << 30), 5, pool)
                .status()
                .code(),
            kRefused);

  const auto lattice = BuildLattice(std::vector<float>(8), 2, pool);
  LatticeBuffers buffers;
  std::vector<float> four(4);
  std::vector<float> five(5);
  const auto filter = [&](std::span<const float> values,
                          int channels,
                          std::span<float> result) {
    return lattice.AddFiltered(values, channels, 1, pool, &buffers, result)
        .code();
  };
  EXPECT_EQ(filter(four, 1, five), kRefused);
  EXPECT_EQ(filter(five, 1, four), kRefused);
  EXPECT_EQ(filter(four, 2, four), kRefused);
  EXPECT_EQ(filter(four, 0, four), kRefused);
}

}  // namespace
}  // namespace freegs::semantics
