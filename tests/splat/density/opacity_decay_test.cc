// SPDX-License-Identifier: BSD-3-Clause

#include "splat/density/opacity_decay.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::splat {
namespace {

double Opacity(double logit) { return 1 / (1 + std::exp(-logit)); }

TEST(OpacityDecayShare, FallsWithTheNumberOfPhotos) {
  const OpacityDecayOptions options{
      .strength = 0.06, .enough_photos = 30, .max_share = 0.01};
  EXPECT_DOUBLE_EQ(OpacityDecayShare(options, 10), 0.004);
  EXPECT_DOUBLE_EQ(OpacityDecayShare(options, 15), 0.002);
  EXPECT_EQ(OpacityDecayShare(options, 30), 0);
  EXPECT_EQ(OpacityDecayShare(options, 1000), 0);
  // No more than max_share, also of photos that do not exist.
  for (const size_t photos : {0, 1, 3}) {
    EXPECT_EQ(OpacityDecayShare(options, photos), 0.01);
  }
  EXPECT_EQ(OpacityDecayShare({.strength = 0}, 3), 0);
}

TEST(OpacityDecay, MultipliesTheOpacity) {
  GaussianModel model;
  model.Resize(20000);
  for (size_t i = 0; i < model.size(); ++i) {
    model.opacity_logits[i] = -15 + 30 * static_cast<float>(i) / 20000;
  }
  GaussianModel same = model;
  GaussianModel alone = model;
  ThreadPool pool(2);
  ThreadPool one(1);
  DecayOpacity(0.05, pool, &same);
  DecayOpacity(0.05, one, &alone);
  EXPECT_EQ(same.opacity_logits, alone.opacity_logits);
  for (size_t i = 0; i < model.size(); ++i) {
    const double before = Opacity(model.opacity_logits[i]);
    const double after = Opacity(same.opacity_logits[i]);
    if (model.opacity_logits[i] > -14.9f) {
      EXPECT_NEAR(after, 0.95 * before, 1e-6 * before);
    }
  }
  DecayOpacity(0, pool, &alone);
  EXPECT_EQ(same.opacity_logits, alone.opacity_logits);
}

TEST(OpacityDecay, EndsBeforeTheLogarithmIsNotFinite) {
  GaussianModel model;
  model.Resize(3);
  model.opacity_logits = {-200, 0, 15};
  ThreadPool pool(1);
  for (int step = 0; step < 2000; ++step) DecayOpacity(0.05, pool, &model);
  EXPECT_EQ(model.opacity_logits, (std::vector<float>{-200, -15, -15}));
}

TEST(OpacityDecay, OptionsAreChecked) {
  EXPECT_TRUE(OpacityDecayOptions().Check().ok());
  EXPECT_FALSE(OpacityDecayOptions{.strength = -1}.Check().ok());
  EXPECT_FALSE(OpacityDecayOptions{.enough_photos = 0}.Check().ok());
  EXPECT_FALSE(OpacityDecayOptions{.max_share = 1}.Check().ok());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(OpacityDecayOptions{.strength = nan}.Check().ok());
  EXPECT_FALSE(OpacityDecayOptions{.max_share = nan}.Check().ok());
}

}  // namespace
}  // namespace freegs::splat
