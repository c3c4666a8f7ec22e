// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/matching/pair_selection.h"

#include <cstdio>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sfm/strip_photos.h"

namespace freegs::sfm {
namespace {

using testing::IsEmpty;

std::vector<std::string> NumberedNames(int count) {
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) {
    char name[32];
    std::snprintf(name, sizeof(name), "frame_%04d.jpg", i);
    names.push_back(name);
  }
  return names;
}

std::vector<std::string> UnnumberedNames(int count) {
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) names.emplace_back(1 + i / 26, 'a' + i % 26);
  return names;
}

PhotoSimilarity Similarity(const std::vector<SiftDescriptors>& photos,
                           int threads = 2) {
  ThreadPool pool(threads);
  return PhotoSimilarity(DescribePhotos(AllFeatures(photos), {}, pool), pool);
}

// Windows every `step` widths, taken in the order i * stride mod count.
std::vector<double> Positions(int count, double step, int stride) {
  std::vector<double> positions;
  for (int i = 0; i < count; ++i) {
    positions.push_back(step * (int64_t{i} * stride % count));
  }
  return positions;
}

bool Connected(int count, const std::set<PhotoPair>& pairs) {
  std::vector<int> part(count);
  std::iota(part.begin(), part.end(), 0);
  for (int round = 0; round < count; ++round) {
    for (const auto& [i, j] : pairs)
      part[i] = part[j] = std::min(part[i], part[j]);
  }
  return std::all_of(part.begin(), part.end(), [](int p) { return p == 0; });
}

void ExpectWellFormed(const std::vector<PhotoPair>& pairs, int count) {
  EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end()));
  EXPECT_EQ(std::set<PhotoPair>(pairs.begin(), pairs.end()).size(),
            pairs.size());
  for (const auto& [i, j] : pairs) {
    EXPECT_LE(0, i);
    EXPECT_LT(i, j);
    EXPECT_LT(j, count);
  }
}

// Share of the pairs that see common features (at least a quarter of a photo).
double Recall(const std::vector<double>& positions,
              const std::vector<PhotoPair>& pairs) {
  const std::set<PhotoPair> chosen(pairs.begin(), pairs.end());
  int overlapping = 0;
  int found = 0;
  for (int i = 0; i < static_cast<int>(positions.size()); ++i) {
    for (int j = i + 1; j < static_cast<int>(positions.size()); ++j) {
      if (std::abs(positions[i] - positions[j]) > 0.75) continue;
      ++overlapping;
      found += chosen.contains({i, j});
    }
  }
  return static_cast<double>(found) / overlapping;
}

TEST(PairSelection, ExhaustiveWhenFew) {
  PairSelectionOptions options;
  for (const int count : {0, 1, 2, 10, options.max_exhaustive}) {
    ASSERT_FALSE(NeedsSimilarity(count, options));
    const PairSelection selection =
        SelectPairs(UnnumberedNames(count), {}, options);
    EXPECT_EQ(selection.strategy, "exhaustive");
    EXPECT_EQ(selection.pairs.size(),
              static_cast<size_t>(count * (count - 1) / 2));
    ExpectWellFormed(selection.pairs, count);
  }
  EXPECT_TRUE(NeedsSimilarity(options.max_exhaustive + 1, options));
  options.matcher = "exhaustive";
  EXPECT_FALSE(NeedsSimilarity(1000, options));
  EXPECT_EQ(SelectPairs(UnnumberedNames(1000), {}, options).pairs.size(),
            499500u);
}

TEST(PairSelection, RetrievalFindsOverlappingPhotosInAnyOrder) {
  constexpr int kCount = 80;
  const auto positions = Positions(kCount, 0.15, 37);
  const auto photos = StripPhotos(positions);
  PairSelectionOptions options;
  options.matcher = "retrieval";
  options.num_neighbours = 10;
  const PairSelection selection =
      SelectPairs(NumberedNames(kCount), Similarity(photos), options);
  EXPECT_EQ(selection.strategy, "retrieval");
  ExpectWellFormed(selection.pairs, kCount);
  // Five windows on each side overlap by a quarter or more.
  EXPECT_GT(Recall(positions, selection.pairs), 0.98);
  EXPECT_LT(selection.pairs.size(), kCount * 10u);
}

TEST(PairSelection, SameForAnyNumberOfThreads) {
  const auto photos = StripPhotos(Positions(60, 0.2, 7));
  const auto pairs =
      SelectPairs(NumberedNames(60), Similarity(photos, 1), {}).pairs;
  for (const int threads : {2, 5}) {
    EXPECT_EQ(
        SelectPairs(NumberedNames(60), Similarity(photos, threads), {}).pairs,
        pairs);
  }
}

TEST(PairSelection, NumberedPhotosAreBelievedOnlyWhenInOrder) {
  constexpr int kCount = 60;
  PairSelectionOptions options;
  options.num_neighbours = 8;
  const auto ordered = StripPhotos(Positions(kCount, 0.4, 1));
  const auto shuffled = StripPhotos(Positions(kCount, 0.4, 23));
  const PairSelection sequence =
      SelectPairs(NumberedNames(kCount), Similarity(ordered), options);
  EXPECT_EQ(sequence.strategy, "sequence and retrieval");
  const std::set<PhotoPair> pairs(sequence.pairs.begin(), sequence.pairs.end());
  for (int i = 0; i + 1 < kCount; ++i) {
    for (int j = i + 1; j < std::min(kCount, i + options.overlap + 1); ++j) {
      EXPECT_TRUE(pairs.contains({i, j}));
    }
  }
  EXPECT_EQ(SelectPairs(NumberedNames(kCount), Similarity(shuffled), options)
                .strategy,
            "retrieval");
  EXPECT_EQ(SelectPairs(UnnumberedNames(kCount), Similarity(ordered), options)
                .strategy,
            "retrieval");
}

TEST(PairSelection, LoopsAreClosed) {
  // The last photos come back to the first.
  std::vector<double> positions;
  for (int i = 0; i < 50; ++i) positions.push_back(0.3 * i);
  for (int i = 0; i < 5; ++i) positions.push_back(0.3 * i + 0.1);
  PairSelectionOptions options;
  options.matcher = "sequential";
  options.num_neighbours = 6;
  const PairSelection selection = SelectPairs(
      UnnumberedNames(55), Similarity(StripPhotos(positions)), options);
  EXPECT_EQ(selection.strategy, "sequence and retrieval");
  const std::set<PhotoPair> pairs(selection.pairs.begin(),
                                  selection.pairs.end());
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(pairs.contains({i, 50 + i}));
  EXPECT_TRUE(pairs.contains({20, 20 + options.overlap}));
}

TEST(PairSelection, PartsThatLookDifferentAreConnected) {
  // Three walls, of which no two have anything in common.
  std::vector<double> positions;
  for (int i = 0; i < 60; ++i) {
    positions.push_back(100.0 * (i % 3) + 0.1 * (i / 3));
  }
  PairSelectionOptions options;
  options.matcher = "retrieval";
  options.num_neighbours = 4;
  const PairSelection selection = SelectPairs(
      UnnumberedNames(60), Similarity(StripPhotos(positions)), options);
  ExpectWellFormed(selection.pairs, 60);
  const std::set<PhotoPair> pairs(selection.pairs.begin(),
                                  selection.pairs.end());
  EXPECT_TRUE(Connected(60, pairs));
  EXPECT_LT(pairs.size(), 60u * 5);
}

TEST(PairSelection, PhotosThatLookLikeNothing) {
  // No features, or the same in all: every photo is still in some pair.
  for (const bool equal : {false, true}) {
    std::vector<SiftDescriptors> photos(50);
    if (equal) {
      for (auto& photo : photos) photo.values.assign(kSiftDimensions * 5, 9);
    }
    const PairSelection selection =
        SelectPairs(NumberedNames(50), Similarity(photos), {});
    ExpectWellFormed(selection.pairs, 50);
    const std::set<PhotoPair> pairs(selection.pairs.begin(),
                                    selection.pairs.end());
    EXPECT_TRUE(Connected(50, pairs));
    EXPECT_EQ(selection.strategy, "retrieval");
  }
}

class MorePairsTest : public testing::Test {
 protected:
  static constexpr int kCount = 40;
  MorePairsTest()
      : similarity_(Similarity(StripPhotos(Positions(kCount, 0.2, 1)))) {
    options_.matcher = "retrieval";
    options_.num_neighbours = 8;
    first_ = SelectPairs(UnnumberedNames(kCount), similarity_, options_).pairs;
    tried_.insert(first_.begin(), first_.end());
  }

  PairSelectionOptions options_;
  PhotoSimilarity similarity_;
  std::vector<PhotoPair> first_;
  std::set<PhotoPair> tried_;
};

TEST_F(MorePairsTest, NoneWhenAllIsWell) {
  EXPECT_THAT(SelectMorePairs(similarity_, tried_, first_, options_),
              IsEmpty());
  EXPECT_THAT(SelectMorePairs({}, tried_, first_, options_), IsEmpty());
}

TEST_F(MorePairsTest, ForPhotosWithFewPartners) {
  std::vector<PhotoPair> verified;
  for (const PhotoPair& pair : first_) {
    if (pair.first != 17 && pair.second != 17) verified.push_back(pair);
  }
  verified.emplace_back(16, 17);
  const auto more = SelectMorePairs(similarity_, tried_, verified, options_);
  EXPECT_EQ(more.size(), 8u);
  ExpectWellFormed(more, kCount);
  for (const PhotoPair& pair : more) {
    EXPECT_TRUE(pair.first == 17 || pair.second == 17);
    EXPECT_FALSE(tried_.contains(pair));
  }
}

TEST_F(MorePairsTest, BetweenPartsThatNothingConnects) {
  std::vector<PhotoPair> verified;
  for (const PhotoPair& pair : first_) {
    if ((pair.first < 15) == (pair.second < 15)) verified.push_back(pair);
  }
  const auto more = SelectMorePairs(similarity_, tried_, verified, options_);
  ExpectWellFormed(more, kCount);
  int across = 0;
  for (const PhotoPair& pair : more) {
    EXPECT_FALSE(tried_.contains(pair));
    across += (pair.first < 15) != (pair.second < 15);
  }
  EXPECT_GE(across, 2 * options_.num_neighbours);
}

TEST_F(MorePairsTest, EndsWhenAllAreTried) {
  for (int i = 0; i < kCount; ++i) {
    for (int j = i + 1; j < kCount; ++j) tried_.insert({i, j});
  }
  EXPECT_THAT(SelectMorePairs(similarity_, tried_, {}, options_), IsEmpty());
}

TEST(PairSelectionOptions, AreChecked) {
  EXPECT_TRUE(PairSelectionOptions().Check().ok());
  PairSelectionOptions options;
  options.matcher = "guess";
  EXPECT_FALSE(options.Check().ok());
  options = {};
  options.num_neighbours = 0;
  EXPECT_FALSE(options.Check().ok());
  options = {};
  options.overlap = 0;
  EXPECT_FALSE(options.Check().ok());
  options = {};
  options.max_exhaustive = -1;
  EXPECT_FALSE(options.Check().ok());
}

}  // namespace
}  // namespace freegs::sfm
