// SPDX-License-Identifier: BSD-3-Clause
// Descriptor matching against a plain double-precision search.

#include "sfm/matching/descriptor_matching.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/for_each_target.h"

namespace freegs::sfm {
namespace {

using Matches = std::vector<std::pair<uint32_t, uint32_t>>;

// Random descriptors of length about 512, as SIFT's.
SiftDescriptors RandomDescriptors(size_t count, uint64_t seed) {
  SiftDescriptors result;
  RandomStream random(seed, 0);
  for (size_t i = 0; i < count; ++i) {
    std::vector<double> values(kSiftDimensions);
    double squared = 0;
    for (double& value : values) {
      value = std::pow(random.Uniform(), 3);
      squared += value * value;
    }
    for (const double value : values) {
      result.values.push_back(static_cast<uint8_t>(
          std::min(255.0, std::round(512 * value / std::sqrt(squared)))));
    }
  }
  return result;
}

// The descriptors of `from` in another order, with noise.
SiftDescriptors Shuffled(const SiftDescriptors& from, double noise) {
  SiftDescriptors result;
  RandomStream random(99, 0);
  for (size_t i = 0; i < from.count(); ++i) {
    const size_t source = (i * 7 + 3) % from.count();
    for (size_t k = 0; k < kSiftDimensions; ++k) {
      const double value =
          from.values[source * kSiftDimensions + k] + noise * random.Normal();
      result.values.push_back(
          static_cast<uint8_t>(std::clamp(value, 0.0, 255.0)));
    }
  }
  return result;
}

double Angle(const SiftDescriptors& a,
             size_t i,
             const SiftDescriptors& b,
             size_t j) {
  double dot = 0, aa = 0, bb = 0;
  for (size_t k = 0; k < kSiftDimensions; ++k) {
    const double x = a.values[i * kSiftDimensions + k];
    const double y = b.values[j * kSiftDimensions + k];
    dot += x * y;
    aa += x * x;
    bb += y * y;
  }
  return std::acos(std::min(1.0, dot / std::sqrt(aa * bb)));
}

// The nearest of b to descriptor i of a if it passes the tests, else -1.
int Nearest(const SiftDescriptors& a, size_t i, const SiftDescriptors& b) {
  double best = 10, second = 10;
  int index = -1;
  for (size_t j = 0; j < b.count(); ++j) {
    const double angle = Angle(a, i, b, j);
    if (angle < best) {
      second = best;
      best = angle;
      index = static_cast<int>(j);
    } else {
      second = std::min(second, angle);
    }
  }
  return best <= 0.7 && best < 0.8 * std::min(second, M_PI) ? index : -1;
}

Matches PlainMatches(const SiftDescriptors& a, const SiftDescriptors& b) {
  Matches matches;
  for (size_t i = 0; i < a.count(); ++i) {
    const int j = Nearest(a, i, b);
    if (j >= 0 && Nearest(b, j, a) == static_cast<int>(i)) {
      matches.emplace_back(i, j);
    }
  }
  return matches;
}

TEST(MatchDescriptors, AgreesWithPlainSearch) {
  // Counts around the sizes of blocks of all vector widths.
  for (const size_t count : {1, 3, 4, 5, 31, 32, 33, 100, 257, 515}) {
    const SiftDescriptors a = RandomDescriptors(count, count);
    SiftDescriptors b = Shuffled(a, 8);
    const SiftDescriptors other = RandomDescriptors(count / 2, 1000 + count);
    b.values.insert(b.values.end(), other.values.begin(), other.values.end());
    const Matches matches = MatchDescriptors(a, b);
    ForEachTarget([&] { EXPECT_EQ(MatchDescriptors(a, b), matches); });
    const Matches expected = PlainMatches(a, b);
    // Lengths differ by rounding only, so hardly any order changes.
    Matches common;
    std::set_intersection(matches.begin(),
                          matches.end(),
                          expected.begin(),
                          expected.end(),
                          std::back_inserter(common));
    EXPECT_EQ(common.size(), matches.size()) << count;
    EXPECT_EQ(common.size(), expected.size()) << count;
    EXPECT_GE(matches.size(), count * 9 / 10);
    for (const auto& [i, j] : matches) {
      EXPECT_EQ((j * 7 + 3) % count, i);
    }
    // Matching b with a finds the same pairs.
    Matches swapped = MatchDescriptors(b, a);
    for (auto& match : swapped) std::swap(match.first, match.second);
    std::sort(swapped.begin(), swapped.end());
    EXPECT_EQ(swapped, matches);
  }
}

TEST(MatchDescriptors, UnrelatedAndEqualDescriptorsDoNotMatch) {
  const SiftDescriptors a = RandomDescriptors(50, 1);
  EXPECT_LT(MatchDescriptors(a, RandomDescriptors(60, 2)).size(), 3u);
  // Each twice: the nearest is not the only one.
  SiftDescriptors twice = a;
  twice.values.insert(twice.values.end(), a.values.begin(), a.values.end());
  EXPECT_TRUE(MatchDescriptors(a, twice).empty());
  EXPECT_TRUE(MatchDescriptors(twice, a).empty());
  EXPECT_EQ(MatchDescriptors(a, a).size(), 50u);
}

TEST(MatchDescriptors, EmptyAndExtremeValues) {
  SiftDescriptors zeros;
  zeros.values.assign(5 * kSiftDimensions, 0);
  SiftDescriptors full;
  full.values.assign(kSiftDimensions, 255);
  EXPECT_TRUE(MatchDescriptors({}, {}).empty());
  EXPECT_TRUE(MatchDescriptors({}, full).empty());
  EXPECT_TRUE(MatchDescriptors(zeros, zeros).empty());
  EXPECT_TRUE(MatchDescriptors(zeros, full).empty());
  EXPECT_EQ(MatchDescriptors(full, full).size(), 1u);
}

}  // namespace
}  // namespace freegs::sfm
