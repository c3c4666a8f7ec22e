// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/matching/global_descriptor.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/sfm/strip_photos.h"

namespace freegs::sfm {
namespace {

double Length(const GlobalDescriptors& descriptors, size_t photo) {
  double squared = 0;
  for (size_t k = 0; k < descriptors.size; ++k) {
    squared += std::pow(descriptors.row(photo)[k], 2);
  }
  return std::sqrt(squared);
}

GlobalDescriptors Describe(const std::vector<PhotoFeatures>& photos,
                           int threads = 1,
                           const GlobalDescriptorOptions& options = {}) {
  ThreadPool pool(threads);
  return DescribePhotos(photos, options, pool);
}

// Windows at the given places, and enough others for a vocabulary: likeness is
// measured against what the scene's photos have in common.
std::vector<SiftDescriptors> PhotosAmongOthers(std::vector<double> positions) {
  for (int i = 0; i < 40; ++i) positions.push_back(5 + 0.5 * i);
  return StripPhotos(positions);
}

TEST(GlobalDescriptor, CloserWindowsAreMoreAlike) {
  const auto photos = PhotosAmongOthers({0, 0, 0.25, 0.5, 0.75, 3});
  const GlobalDescriptors result = Describe(AllFeatures(photos));
  ASSERT_EQ(result.count, photos.size());
  for (size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(Length(result, i), 1, 1e-5);
    EXPECT_NEAR(result.Similarity(i, i), 1, 1e-4);
  }
  for (size_t j = 1; j + 1 < 6; ++j) {
    EXPECT_GT(result.Similarity(0, j), result.Similarity(0, j + 1) + 0.02) << j;
    EXPECT_EQ(result.Similarity(0, j), result.Similarity(j, 0));
  }
  for (size_t j = 5; j < photos.size(); ++j) {
    EXPECT_LT(std::abs(result.Similarity(0, j)), 0.2) << j;
  }
}

TEST(GlobalDescriptor, SameBytesForAnyNumberOfThreads) {
  std::vector<double> positions;
  for (int i = 0; i < 20; ++i) positions.push_back(0.1 * i);
  const auto photos = StripPhotos(positions);
  const GlobalDescriptors one = Describe(AllFeatures(photos), 1);
  for (const int threads : {2, 3, 8}) {
    EXPECT_TRUE(Describe(AllFeatures(photos), threads).values == one.values);
  }
  GlobalDescriptorOptions other;
  other.seed = 1;
  EXPECT_FALSE(Describe(AllFeatures(photos), 1, other).values == one.values);
}

TEST(GlobalDescriptor, NothingToDescribe) {
  EXPECT_EQ(Describe({}).count, 0u);
  const std::vector<SiftDescriptors> empty(3);
  const GlobalDescriptors result = Describe(AllFeatures(empty));
  EXPECT_EQ(result.count, 3u);
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(Length(result, i), 0);
  EXPECT_EQ(result.Similarity(0, 1), 0);
}

TEST(GlobalDescriptor, PhotosWithoutFeaturesBesideOthers) {
  auto photos = PhotosAmongOthers({0, 0.5, 0.1});
  photos[1].values.clear();
  const GlobalDescriptors result = Describe(AllFeatures(photos));
  EXPECT_EQ(Length(result, 1), 0);
  EXPECT_EQ(result.Similarity(0, 1), 0);
  EXPECT_GT(result.Similarity(0, 2), 0.3);
}

TEST(GlobalDescriptor, OddDescriptorsGiveFiniteNumbers) {
  std::vector<SiftDescriptors> photos(4);
  photos[0].values.assign(kSiftDimensions * 300, 0);    // All zero.
  photos[1].values.assign(kSiftDimensions * 300, 255);  // All full.
  photos[2].values.assign(kSiftDimensions, 7);          // One feature.
  photos[3].values.assign(100, 7);                      // Less than one.
  const GlobalDescriptors result = Describe(AllFeatures(photos));
  for (const float value : result.values) EXPECT_TRUE(std::isfinite(value));
  const std::vector<SiftDescriptors> one(photos.begin() + 2,
                                         photos.begin() + 3);
  const GlobalDescriptors alone = Describe(AllFeatures(one));
  EXPECT_EQ(alone.count, 1u);
  for (const float value : alone.values) EXPECT_TRUE(std::isfinite(value));
}

TEST(GlobalDescriptor, LargestFeaturesAreUsed) {
  // Two photos of the same place whose many small features differ.
  const auto place = StripPhotos({0, 0, 5, 9, 13});
  std::vector<SiftDescriptors> photos(3);
  photos[0] = place[0];
  photos[1] = place[1];
  photos[2] = place[2];
  for (int i = 0; i < 2; ++i) {
    photos[i].values.insert(photos[i].values.end(),
                            place[3 + i].values.begin(),
                            place[3 + i].values.end());
  }
  GlobalDescriptorOptions options;
  options.max_features = kStripFeatures;
  std::vector<PhotoFeatures> features = AllFeatures(photos);
  const GlobalDescriptors evenly = Describe(features, 1, options);
  for (int i = 0; i < 2; ++i) {
    features[i].scales.assign(2 * kStripFeatures, 1.0f);
    std::fill_n(features[i].scales.begin(), kStripFeatures, 5.0f);
  }
  const GlobalDescriptors by_scale = Describe(features, 1, options);
  EXPECT_GT(by_scale.Similarity(0, 1), evenly.Similarity(0, 1) + 0.2);
  // Scales that are not one per feature are as good as none.
  for (int i = 0; i < 2; ++i) features[i].scales.resize(3);
  EXPECT_TRUE(Describe(features, 1, options).values == evenly.values);
}

TEST(GlobalDescriptor, OptionsAreChecked) {
  EXPECT_TRUE(GlobalDescriptorOptions().Check().ok());
  GlobalDescriptorOptions options;
  options.words = 0;
  EXPECT_FALSE(options.Check().ok());
  options = {};
  options.max_features = 0;
  EXPECT_FALSE(options.Check().ok());
  options = {};
  options.max_training = -1;
  EXPECT_FALSE(options.Check().ok());
}

}  // namespace
}  // namespace freegs::sfm
