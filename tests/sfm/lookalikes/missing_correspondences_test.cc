// SPDX-License-Identifier: BSD-3-Clause
// Points that photos should share.

#include "sfm/lookalikes/missing_correspondences.h"

#include <gtest/gtest.h>

#include "tests/sfm/synthetic_model.h"
#include "tests/sfm/twin_scene.h"

namespace freegs::sfm {
namespace {

TEST(FindMissingCorrespondences, NoneWhereAllSeeAll) {
  const auto views =
      FindMissingCorrespondences(SyntheticModel(24, 200), AllPairs());
  EXPECT_FALSE(views.empty());
  for (const SharedView& view : views) {
    EXPECT_LT(view.image_id1, view.image_id2);
    EXPECT_LT(view.angle_deg, 30);
    EXPECT_EQ(view.claimed, view.shared);
    EXPECT_EQ(view.missing, 0);
  }
}

TEST(FindMissingCorrespondences, TwoPhotosAndNone) {
  EXPECT_TRUE(FindMissingCorrespondences({}, AllPairs()).empty());
  for (const SharedView& view :
       FindMissingCorrespondences(SyntheticModel(2, 50), AllPairs())) {
    EXPECT_EQ(view.missing, 0);
  }
}

TEST(FindMissingCorrespondences, BetweenGluedHalves) {
  const TwinScene scene(23);
  double within = 0;
  double across = 0;
  for (const SharedView& view :
       FindMissingCorrespondences(scene.Model(true), AllPairs())) {
    const bool same = scene.InSecondHalf(view.image_id1 - 1) ==
                      scene.InSecondHalf(view.image_id2 - 1);
    (same ? within : across) += view.missing;
  }
  EXPECT_GT(across, 500);
  EXPECT_GT(across, 5 * within);
}

// Pairs of photos that were not compared are not examined.
TEST(FindMissingCorrespondences, NotWhereNothingWasCompared) {
  const TwinScene scene(23);
  std::set<std::pair<uint32_t, uint32_t>> within;
  for (const auto& [id1, id2] : AllPairs()) {
    if (scene.InSecondHalf(static_cast<int>(id1) - 1) ==
        scene.InSecondHalf(static_cast<int>(id2) - 1)) {
      within.insert({id1, id2});
    }
  }
  const auto views = FindMissingCorrespondences(scene.Model(true), within);
  EXPECT_FALSE(views.empty());
  for (const SharedView& view : views) {
    EXPECT_TRUE(within.contains({view.image_id1, view.image_id2}));
  }
}

}  // namespace
}  // namespace freegs::sfm
