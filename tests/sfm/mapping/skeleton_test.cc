// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/mapping/skeleton.h"

#include <algorithm>
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::sfm {
namespace {

using VerifiedPair = MatchDatabase::VerifiedPair;

VerifiedPair Matching(uint32_t id1, uint32_t id2, int64_t num_matches) {
  VerifiedPair pair;
  pair.id1 = id1;
  pair.id2 = id2;
  pair.num_matches = num_matches;
  return pair;
}

// A film of photos that overlap with so many before and after them.
std::vector<VerifiedPair> Film(uint32_t photos, uint32_t overlap) {
  std::vector<VerifiedPair> pairs;
  for (uint32_t i = 1; i <= photos; ++i) {
    for (uint32_t j = i + 1; j <= std::min(photos, i + overlap); ++j) {
      pairs.push_back(Matching(i, j, 200));
    }
  }
  return pairs;
}

int64_t PartnersWithin(const std::vector<uint32_t>& skeleton,
                       uint32_t photo,
                       uint32_t overlap) {
  return std::count_if(skeleton.begin(), skeleton.end(), [&](uint32_t other) {
    const auto apart = std::abs(static_cast<int64_t>(other) - photo);
    return apart > 0 && apart <= overlap;
  });
}

TEST(SkeletonTest, EveryPhotoHasItsPartners) {
  const auto skeleton = ChooseSkeleton(Film(100, 8));
  EXPECT_LT(skeleton.size(), 60u);
  EXPECT_TRUE(std::is_sorted(skeleton.begin(), skeleton.end()));
  for (uint32_t photo = 1; photo <= 100; ++photo) {
    EXPECT_GE(PartnersWithin(skeleton, photo, 8), kSkeletonPartners) << photo;
  }
}

TEST(SkeletonTest, PhotosWithFewPartnersHaveAllOfThem) {
  const auto skeleton = ChooseSkeleton(Film(5, 1));
  EXPECT_THAT(skeleton, testing::ElementsAre(1, 2, 3, 4, 5));
}

TEST(SkeletonTest, FewMatchesMakeNoPartners) {
  std::vector<VerifiedPair> pairs = Film(30, 10);
  const auto skeleton = ChooseSkeleton(pairs);
  pairs.push_back(Matching(3, 31, 49));
  EXPECT_EQ(ChooseSkeleton(pairs), skeleton);
  pairs.back().num_matches = 50;
  EXPECT_THAT(ChooseSkeleton(pairs), testing::Contains(3));
}

TEST(SkeletonTest, ManyPairsDoNotMakeItSmall) {
  std::vector<VerifiedPair> pairs;
  for (uint32_t i = 1; i <= 100; ++i) {
    for (uint32_t j = i + 1; j <= 100; ++j) {
      pairs.push_back(Matching(i, j, 1000 - 5 * static_cast<int64_t>(j - i)));
    }
  }
  const auto skeleton = ChooseSkeleton(pairs);
  EXPECT_GT(skeleton.size(), 25u);
  for (uint32_t photo = 1; photo <= 100; ++photo) {
    EXPECT_GE(PartnersWithin(skeleton, photo, 20), kSkeletonPartners) << photo;
  }
}

TEST(SkeletonTest, OrderOfPairsDoesNotMatter) {
  std::vector<VerifiedPair> pairs = Film(60, 9);
  const auto skeleton = ChooseSkeleton(pairs);
  std::reverse(pairs.begin(), pairs.end());
  EXPECT_EQ(ChooseSkeleton(pairs), skeleton);
}

TEST(SkeletonTest, NoPairsNoSkeleton) {
  EXPECT_TRUE(ChooseSkeleton({}).empty());
}

}  // namespace
}  // namespace freegs::sfm
