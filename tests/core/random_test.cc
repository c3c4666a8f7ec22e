// SPDX-License-Identifier: BSD-3-Clause

#include "core/random.h"

#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace freegs {
namespace {

// Published outputs of SplitMix64: the generator adds the golden gamma and
// finalises, which is MixBits of 0, gamma, 2 gamma, ...
TEST(RandomTest, MixBitsIsSplitMix64) {
  constexpr uint64_t kGamma = 0x9e3779b97f4a7c15ULL;
  EXPECT_EQ(MixBits(0), 0xe220a8397b1dcdafULL);
  EXPECT_EQ(MixBits(kGamma), 0x6e789e6aa1b965f4ULL);
  EXPECT_EQ(MixBits(2 * kGamma), 0x06c45d188009454fULL);
}

TEST(RandomTest, ValuesArePureFunctionsOfTheirCoordinates) {
  EXPECT_EQ(RandomBits(1, 2, 3), RandomBits(1, 2, 3));
  EXPECT_NE(RandomBits(1, 2, 3), RandomBits(2, 2, 3));
  EXPECT_NE(RandomBits(1, 2, 3), RandomBits(1, 3, 3));
  EXPECT_NE(RandomBits(1, 2, 3), RandomBits(1, 2, 4));
  EXPECT_NE(RandomBits(1, 2, 3), RandomBits(1, 3, 2));
}

TEST(RandomTest, UniformMoments) {
  constexpr int kCount = 200000;
  double sum = 0;
  double squares = 0;
  double lag = 0;
  for (int i = 0; i < kCount; ++i) {
    const double u = RandomUniform(7, 3, i);
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    squares += u * u;
    lag += (u - 0.5) * (RandomUniform(7, 3, i + 1) - 0.5);
  }
  EXPECT_NEAR(sum / kCount, 0.5, 0.003);
  EXPECT_NEAR(squares / kCount, 1.0 / 3.0, 0.003);
  EXPECT_NEAR(lag / kCount, 0.0, 0.001);
}

TEST(RandomTest, NormalMoments) {
  constexpr int kCount = 200000;
  double moments[5] = {};
  for (int i = 0; i < kCount; ++i) {
    const double x = RandomNormal(11, 0, i);
    double power = 1;
    for (double& moment : moments) {
      moment += power / kCount;
      power *= x;
    }
  }
  EXPECT_NEAR(moments[1], 0.0, 0.01);
  EXPECT_NEAR(moments[2], 1.0, 0.02);
  EXPECT_NEAR(moments[3], 0.0, 0.05);
  EXPECT_NEAR(moments[4], 3.0, 0.1);
}

TEST(RandomTest, IndexIsInRangeAndEven) {
  constexpr int kCount = 70000;
  std::vector<int> counts(7);
  for (int i = 0; i < kCount; ++i) {
    const uint64_t index = RandomIndex(5, 9, i, 7);
    ASSERT_LT(index, 7u);
    ++counts[index];
  }
  for (const int count : counts) EXPECT_NEAR(count, 10000, 400);
  EXPECT_EQ(RandomIndex(5, 9, 1, 1), 0u);
}

TEST(RandomTest, StreamGivesTheSameNumbers) {
  RandomStream stream(3, 4);
  EXPECT_EQ(stream.Bits(), RandomBits(3, 4, 0));
  EXPECT_EQ(stream.Uniform(), RandomUniform(3, 4, 1));
  EXPECT_EQ(stream.Index(10), RandomIndex(3, 4, 2, 10));
  RandomStream again(3, 4);
  again.Bits();
  again.Uniform();
  again.Index(10);
  EXPECT_EQ(stream.Normal(), again.Normal());
}

}  // namespace
}  // namespace freegs
