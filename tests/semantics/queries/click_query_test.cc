// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/queries/click_query.h"

#include <cmath>
#include <limits>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/splat/test_scene.h"

namespace freegs::semantics {
namespace {

using testing::ElementsAre;

std::vector<int32_t> MixedLabels(size_t count) {
  std::vector<int32_t> labels;
  for (size_t i = 0; i < count; ++i) {
    labels.push_back(static_cast<int32_t>(i % 5) - 1);
  }
  return labels;
}

TEST(ClickQueryTest, AnswersWhatTheLabelImageShows) {
  ThreadPool pool(2);
  const splat::GaussianModel model = splat::RandomSceneModel(200, 0, 3);
  const std::vector<int32_t> labels = MixedLabels(model.size());
  const Pinhole camera = splat::TestCamera(40, 30);
  const View view{"", camera, splat::TestPose()};
  const Image<int32_t> image =
      splat::RenderLabels(model, camera, view.cam_from_world, {}, pool, labels);
  std::set<int> seen;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const auto hits = QueryClick(model, labels, view, {}, {x, y}, pool);
      ASSERT_TRUE(hits.ok());
      EXPECT_EQ(hits->empty() ? -1 : (*hits)[0].id - 1, image(x, y))
          << x << " " << y;
      seen.insert(image(x, y));
      for (size_t k = 1; k < hits->size(); ++k) {
        EXPECT_LE((*hits)[k].weight, (*hits)[k - 1].weight);
      }
    }
  }
  EXPECT_EQ(seen.size(), 5u);  // Or the test says little.
}

TEST(ClickQueryTest, ThePointLiesOnTheRayAtTheInstancesDepth) {
  ThreadPool pool(1);
  splat::GaussianModel model;
  model.Resize(1);
  model.rotations[0] = 1;
  model.opacity_logits[0] = 6;
  for (float& scale : model.log_scales) scale = std::log(0.4f);
  const Pinhole camera = splat::TestCamera(40, 30);
  const Rigid3d pose = splat::TestPose();
  const auto hits = QueryClick(
      model, std::vector<int32_t>{6}, {"", camera, pose}, {}, {23, 11}, pool);
  ASSERT_TRUE(hits.ok());
  ASSERT_EQ(hits->size(), 1u);
  EXPECT_EQ((*hits)[0].id, 7);
  const Eigen::Vector3d seen = pose * (*hits)[0].point;
  EXPECT_NEAR(camera.fx * seen.x() / seen.z() + camera.cx, 23.5, 1e-6);
  EXPECT_NEAR(camera.fy * seen.y() / seen.z() + camera.cy, 11.5, 1e-6);
  EXPECT_NEAR(seen.z(), pose.translation.z(), 1e-6);
}

// Two instances show in one pixel, one behind the other.
TEST(ClickQueryTest, EachPointLiesAtItsOwnInstancesDepth) {
  ThreadPool pool(1);
  const Pinhole camera = splat::TestCamera(40, 30);
  const Rigid3d pose = splat::TestPose();
  splat::GaussianModel model;
  model.Resize(2);
  for (float& scale : model.log_scales) scale = std::log(0.4f);
  model.rotations[0] = model.rotations[4] = 1;
  model.opacity_logits = {0, 6};
  const Eigen::Vector3d behind =
      pose.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  for (int k = 0; k < 3; ++k) {
    model.means[3 + k] = static_cast<float>(behind[k]);
  }
  const auto hits = QueryClick(model,
                               std::vector<int32_t>{6, 2},
                               {"", camera, pose},
                               {},
                               {20, 15},
                               pool);
  ASSERT_TRUE(hits.ok());
  ASSERT_EQ(hits->size(), 2u);
  for (const ClickHit& hit : *hits) {
    EXPECT_NEAR((pose * hit.point).z(),
                pose.translation.z() + (hit.id == 7 ? 0 : 1),
                1e-5);
  }
}

TEST(ClickQueryTest, WrongArguments) {
  ThreadPool pool(1);
  const splat::GaussianModel model = splat::RandomSceneModel(10, 0, 3);
  const View view{"", splat::TestCamera(40, 30), splat::TestPose()};
  const auto code = [&](const std::vector<int32_t>& labels, int x) {
    return QueryClick(model, labels, view, {}, {x, 3}, pool).status().code();
  };
  EXPECT_EQ(code(MixedLabels(9), 5), StatusCode::kInvalidArgument);
  EXPECT_EQ(code(MixedLabels(10), 40), StatusCode::kInvalidArgument);
  EXPECT_EQ(code(MixedLabels(10), 5), StatusCode::kOk);
}

// A plane (0) with a block (1) of 12 x 12 on it, a thin diagonal (2) of 24, and
// a stray pixel of the block far away.
Image<int32_t> Picture() {
  Image<int32_t> image(90, 60, 1, 0);
  for (int y = 0; y < 60; ++y) {
    for (int x = 87; x < 90; ++x) image(x, y) = -1;
  }
  for (int y = 12; y < 24; ++y) {
    for (int x = 15; x < 27; ++x) image(x, y) = 1;
  }
  for (int k = 0; k < 24; ++k) image(45 + k, 18 + k) = 2;
  image(3, 54) = 1;
  return image;
}

std::vector<int> Ids(const StatusOr<std::vector<BoxHit>>& hits) {
  EXPECT_TRUE(hits.ok()) << hits.status().message();
  std::vector<int> ids;
  for (const BoxHit& hit : *hits) ids.push_back(hit.id);
  return ids;
}

TEST(BoxQueryTest, TheInstanceThatTheBoxIsDrawnAround) {
  const auto block = QueryBox(Picture(), {15, 12, 27, 24}, {});
  EXPECT_THAT(Ids(block), ElementsAre(2));
  EXPECT_NEAR((*block)[0].iou, 1, 1e-9);
  // The plane fills the box, the diagonal only its own pixels.
  const auto thin = QueryBox(Picture(), {69, 42, 45, 18}, {});
  EXPECT_THAT(Ids(thin), ElementsAre(3, 1));
  EXPECT_NEAR((*thin)[0].iou, 1, 1e-9);
  EXPECT_NEAR((*thin)[1].iou, 576.0 / (87 * 60), 1e-9);
}

TEST(BoxQueryTest, LargePlanesOnlyWhenAskedFor) {
  const std::vector<uint8_t> background = {1};
  EXPECT_THAT(Ids(QueryBox(Picture(), {0, 0, 90, 60}, {}, background)),
              ElementsAre(3, 2));
  EXPECT_THAT(Ids(QueryBox(
                  Picture(), {0, 0, 90, 60}, {.background = true}, background)),
              ElementsAre(1, 3, 2));
  EXPECT_THAT(Ids(QueryBox(Picture(), {30, 0, 36, 6}, {}, background)),
              ElementsAre());
}

TEST(BoxQueryTest, BoxesAreCutAtTheImage) {
  EXPECT_THAT(Ids(QueryBox(Picture(), {-1e300, -15, 27, 24}, {})),
              ElementsAre(2, 1));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const PixelBox& box : {PixelBox{15, 12, 15, 24},
                              PixelBox{90, 12, 120, 24},
                              PixelBox{-27, 12, -3, 24},
                              PixelBox{nan, 12, 27, 24},
                              PixelBox{0, 12, inf, 24}}) {
    EXPECT_EQ(QueryBox(Picture(), box, {}).status().code(),
              StatusCode::kInvalidArgument);
  }
  EXPECT_FALSE(QueryBox(Image<int32_t>(), {0, 0, 1, 1}, {}).ok());
}

}  // namespace
}  // namespace freegs::semantics
