// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/view_cues.h"

#include <gtest/gtest.h>

#include "tests/semantics/synthetic_gaussians.h"

namespace freegs::semantics {
namespace {

class ViewCuesTest : public testing::Test {
 protected:
  ViewCuesTest() : scene_(MakeTableScene()), view_(LookAtOrigin(0.4)) {
    view_.camera = view_.camera.Resized(80, 60);
    auto weights = splat::ComputeBlendingWeights(scene_.model,
                                                 view_.camera,
                                                 view_.cam_from_world,
                                                 splat::RenderOptions(),
                                                 pool_);
    weights_ = *std::move(weights);
  }

  StatusOr<ViewCues> Find(const splat::GaussianModel& model,
                          const View& view,
                          const ImageF& photo,
                          double baseline) {
    return FindViewCues(model, weights_.matrix(), view, photo, baseline, pool_);
  }

  ThreadPool pool_{2};
  const SyntheticGaussians scene_;
  View view_;
  splat::BlendingWeights weights_;
};

TEST_F(ViewCuesTest, WindowsGrowWithTheImage) {
  const auto cues = Find(scene_.model, view_, ImageF(80, 60, 3), 1);
  ASSERT_TRUE(cues.ok());
  EXPECT_EQ(cues->near_reach, 2);  // Never less.
  EXPECT_EQ(cues->far_reach, 2);
  EXPECT_EQ(cues->lab.width(), 80);
  EXPECT_EQ(cues->weights.num_gaussians, scene_.model.size());
}

TEST_F(ViewCuesTest, AnEdgeOfThePhotographIsABoundary) {
  ImageF photo(80, 60, 3);
  for (int y = 0; y < 60; ++y) {
    for (int x = 40; x < 80; ++x) {
      for (int c = 0; c < 3; ++c) photo(x, y, c) = 1;
    }
  }
  const auto cues = Find(scene_.model, view_, photo, 1);
  ASSERT_TRUE(cues.ok());
  EXPECT_GT(cues->contrast.Across(39, 30, true, cues->near_reach).contrast,
            0.9);
  EXPECT_EQ(cues->contrast.Across(20, 30, true, cues->near_reach).contrast, 0);
}

// Cameras that all stand in one place see no depth.
TEST_F(ViewCuesTest, NoReliefWithoutABaseline) {
  const ImageF photo(80, 60, 3);
  const auto apart = Find(scene_.model, view_, photo, 1);
  const auto together = Find(scene_.model, view_, photo, 0);
  ASSERT_TRUE(apart.ok() && together.ok());
  double sum = 0;
  for (int y = 0; y < 59; ++y) {
    for (int x = 0; x < 79; ++x) {
      sum += apart->relief.Step(x, y, true, apart->relief_reach);
      EXPECT_LT(together->relief.Step(x, y, true, together->relief_reach),
                1e-6);
    }
  }
  EXPECT_GT(sum, 0);
}

TEST_F(ViewCuesTest, RefusesWhatIsOfAnotherSize) {
  const auto refuses = [&](const splat::GaussianModel& model,
                           const View& view,
                           const ImageF& photo) {
    return Find(model, view, photo, 1).status().code() ==
           StatusCode::kInvalidArgument;
  };
  const ImageF photo(80, 60, 3);
  EXPECT_FALSE(refuses(scene_.model, view_, photo));
  EXPECT_TRUE(refuses(scene_.model, view_, ImageF(80, 61, 3)));
  View other = view_;
  other.camera = other.camera.Resized(40, 30);
  EXPECT_TRUE(refuses(scene_.model, other, photo));
  EXPECT_TRUE(refuses(splat::GaussianModel(), view_, photo));
}

}  // namespace
}  // namespace freegs::semantics
