// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/colmap/sfm_options.h"

#include <gtest/gtest.h>

namespace freegs::sfm {
namespace {

TEST(SfmOptions, FewPhotosGetMoreFeatures) {
  SfmOptions options;
  EXPECT_EQ(options.FeaturesOf(500), 3000);
  EXPECT_EQ(options.FeaturesOf(20), 3000);
  EXPECT_EQ(options.FeaturesOf(19), 8000);
  options.max_features = 1200;
  EXPECT_EQ(options.FeaturesOf(3), 3200);
  options.max_features = 4000;
  EXPECT_EQ(options.FeaturesOf(3), 8000);
  options.max_features = 9000;
  EXPECT_EQ(options.FeaturesOf(3), 9000);
  options.max_features = 100000;
  EXPECT_EQ(options.FeaturesOf(3), 100000);
}

}  // namespace
}  // namespace freegs::sfm
