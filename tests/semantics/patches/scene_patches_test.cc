// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/scene_patches.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "semantics/geometry/view_choice.h"
#include "tests/semantics/synthetic_gaussians.h"

namespace freegs::semantics {
namespace {

StatusOr<std::vector<ScenePatches>> DivisionsOf(
    const splat::GaussianModel& model,
    const std::vector<View>& views,
    int threads) {
  ThreadPool pool(threads);
  const splat::RenderOptions render;
  return BuildScenePatches(
      {.model = model,
       .views = views,
       .render = render,
       .photo_of = [&](size_t v) -> StatusOr<ImageU8> {
         ImageU8 photo(views[v].camera.width, views[v].camera.height, 3);
         for (size_t i = 0; i < photo.size(); ++i) {
           photo.data()[i] = static_cast<uint8_t>(i % 251);
         }
         return photo;
       },
       .scene_radius = 1},
      pool,
      nullptr);
}

StatusOr<ScenePatches> PatchesOf(const splat::GaussianModel& model,
                                 const std::vector<View>& views) {
  FREEGS_ASSIGN_OR_RETURN(std::vector<ScenePatches> divisions,
                          DivisionsOf(model, views, 2));
  return std::move(divisions[0]);
}

std::vector<View> SomeViews(int count) {
  std::vector<View> views;
  for (int v = 0; v < count; ++v) {
    views.push_back(LookAtOrigin(0.9 * v));
    views.back().camera = views.back().camera.Resized(80, 60);
  }
  return views;
}

TEST(ScenePatchesTest, EachDivisionHasOtherPatches) {
  const SyntheticGaussians scene = MakeTableScene();
  const std::vector<View> views = SomeViews(3);
  const auto divisions = DivisionsOf(scene.model, views, 1);
  const auto threads = DivisionsOf(scene.model, views, 3);
  ASSERT_TRUE(divisions.ok() && threads.ok());
  ASSERT_EQ(divisions->size(), static_cast<size_t>(kNumDivisions));
  for (size_t d = 0; d < divisions->size(); ++d) {
    const ScenePatches& patches = (*divisions)[d];
    EXPECT_EQ(patches.patch_of_gaussian, (*threads)[d].patch_of_gaussian);
    EXPECT_EQ(patches.seen, (*threads)[d].seen);
    EXPECT_EQ(patches.graph.PixelsOfRegions(),
              (*threads)[d].graph.PixelsOfRegions());
    // All are of the same Gaussians.
    EXPECT_EQ(patches.seen, (*divisions)[0].seen);
    for (size_t g = 0; g < patches.patch_of_gaussian.size(); ++g) {
      EXPECT_EQ(patches.patch_of_gaussian[g] < 0,
                (*divisions)[0].patch_of_gaussian[g] < 0);
    }
    for (size_t other = 0; other < d; ++other) {
      EXPECT_NE(patches.patch_of_gaussian,
                (*divisions)[other].patch_of_gaussian);
    }
  }
}

TEST(ScenePatchesTest, WithoutMatterNoDivisionHasPatches) {
  SyntheticGaussians scene = MakeTableScene();
  std::fill(scene.model.opacity_logits.begin(),
            scene.model.opacity_logits.end(),
            -9.0f);
  const auto divisions = DivisionsOf(scene.model, SomeViews(2), 1);
  ASSERT_TRUE(divisions.ok());
  ASSERT_EQ(divisions->size(), static_cast<size_t>(kNumDivisions));
  for (const ScenePatches& patches : *divisions) {
    EXPECT_EQ(patches.patch_of_gaussian,
              std::vector<int32_t>(scene.model.size(), -1));
    EXPECT_EQ(patches.seen.size(), scene.model.size());
    EXPECT_TRUE(patches.graph.regions.empty());
  }
}

TEST(ScenePatchesTest, NothingDependsOnViewsThatAreNotChosen) {
  const SyntheticGaussians scene = MakeTableScene();
  constexpr size_t kNumViews = kMaxPatchViews + 6;
  const std::vector<size_t> chosen = ChooseViews(kNumViews, kMaxPatchViews);
  std::vector<View> all;
  std::vector<View> few;
  for (size_t v = 0; v < kNumViews; ++v) {
    View view = LookAtOrigin(0.2 * static_cast<double>(v));
    view.camera = view.camera.Resized(80, 60);
    if (std::find(chosen.begin(), chosen.end(), v) != chosen.end()) {
      few.push_back(view);
    } else {
      view.camera.fx *= 4;  // Would make patches smaller.
      view.camera.fy *= 4;
    }
    all.push_back(view);
  }
  const auto of_all = PatchesOf(scene.model, all);
  const auto of_few = PatchesOf(scene.model, few);
  ASSERT_TRUE(of_all.ok() && of_few.ok());
  EXPECT_GT(of_all->graph.regions.size(), 1u);
  EXPECT_EQ(of_all->patch_of_gaussian, of_few->patch_of_gaussian);
  EXPECT_EQ(of_all->seen, of_few->seen);
  EXPECT_EQ(of_all->graph.contacts.size(), of_few->graph.contacts.size());
}

double DepthSteps(const ScenePatches& patches) {
  double sum = 0;
  for (const Contact& contact : patches.graph.contacts) {
    sum += contact.stats.depth_step;
  }
  return sum;
}

// Cameras so close together that it is the focal length which says what a
// difference in depth is worth. That of one view does not, not even the first.
TEST(ScenePatchesTest, TheFirstViewIsOneLikeTheOthers) {
  const SyntheticGaussians scene = MakeTableScene();
  std::vector<View> views;
  for (int v = 0; v < 5; ++v) views.push_back(LookAtOrigin(0.02 * v));
  views.back().camera.fx *= 2;
  views.back().camera.fy *= 2;
  const auto last = PatchesOf(scene.model, views);
  std::rotate(views.begin(), views.end() - 1, views.end());
  const auto first = PatchesOf(scene.model, views);
  ASSERT_TRUE(last.ok() && first.ok());
  EXPECT_GT(DepthSteps(*last), 0);
  EXPECT_NEAR(DepthSteps(*first) / DepthSteps(*last), 1, 1e-4);
}

}  // namespace
}  // namespace freegs::semantics
