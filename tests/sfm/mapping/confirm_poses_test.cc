// SPDX-License-Identifier: BSD-3-Clause
// Further mappings that agree with the first one, or do not.

#include "sfm/mapping/confirm_poses.h"

#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sfm/moved_photos.h"
#include "tests/sfm/synthetic_model.h"

namespace freegs::sfm {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using Models = std::vector<Reconstruction>;

constexpr int kNumPhotos = 10;

class ConfirmPosesTest : public testing::Test {
 protected:
  // A model with all photos, of which those of `moved` are in a wrong place.
  static Reconstruction Model(const std::vector<size_t>& moved = {}) {
    Reconstruction model = InAnotherWorld(SyntheticModel(kNumPhotos, 20));
    for (const size_t i : moved) MovePhoto(i, &model);
    return model;
  }

  // No two models of different mappings are the same to the last digit.
  static Reconstruction Another(Reconstruction model, double by) {
    for (PosedImage& image : model.images) {
      image.cam_from_world.translation.x() += 1e-6 * by;
    }
    return model;
  }

  // Maps again to these models in turn, or to none in place of an empty one.
  // Then COLMAP's own choice leads to the first models again.
  StatusOr<ConfirmedPoses> Run(const Models& first, const Models& further) {
    return ConfirmPoses(first,
                        kNumPhotos / 2,
                        [&](const std::string&, std::optional<size_t> skip)
                            -> StatusOr<std::optional<AttemptResult>> {
                          AttemptResult result;
                          if (!skip) {
                            ++colmaps_own_;
                            result.models = first;
                            return std::optional(result);
                          }
                          calls_ = *skip;
                          if (*skip > further.size())
                            return std::optional<AttemptResult>();
                          result.repairs = repairs_;
                          if (further[*skip - 1].images.empty()) {
                            result.problem = problem_;
                            return std::optional(result);
                          }
                          result.models.push_back(Another(
                              further[*skip - 1], static_cast<double>(*skip)));
                          return std::optional(result);
                        });
  }

  std::vector<Attempt> repairs_;  // One for each mapping.
  std::string problem_;           // What a mapping without a model says.
  size_t calls_ = 0;
  int colmaps_own_ = 0;
};

TEST_F(ConfirmPosesTest, OneThatAgreesIsEnough) {
  const auto confirmed = Run({Model()}, {Model(), Model()});
  ASSERT_TRUE(confirmed.ok());
  EXPECT_EQ(calls_, 1u);
  EXPECT_TRUE(confirmed->witnessed);
  EXPECT_THAT(confirmed->models, IsEmpty());
  EXPECT_THAT(confirmed->uncertain, IsEmpty());
  EXPECT_FALSE(confirmed->replaced);
  ASSERT_THAT(confirmed->attempts, SizeIs(1));
  EXPECT_FALSE(confirmed->attempts[0].kept);
  EXPECT_THAT(confirmed->attempts[0].problem, HasSubstr("10 of 10 photos"));
}

TEST_F(ConfirmPosesTest, AnUnconfirmedPhotoIsTakenOut) {
  Reconstruction other = Model();
  other.images.resize(1);
  const auto confirmed = Run({Model({3}), other}, {Model()});
  ASSERT_TRUE(confirmed.ok());
  EXPECT_FALSE(confirmed->replaced);
  EXPECT_THAT(confirmed->uncertain, ElementsAre(PhotoName(3)));
  ASSERT_THAT(confirmed->models, SizeIs(2));
  EXPECT_THAT(confirmed->models[0].images, SizeIs(kNumPhotos - 1));
  EXPECT_TRUE(CheckReconstruction(confirmed->models[0]).ok());
  EXPECT_THAT(confirmed->models[1].images, SizeIs(1));
}

TEST_F(ConfirmPosesTest, TheModelThatAnotherConfirmsIsTaken) {
  Reconstruction elsewhere = Model();
  for (PosedImage& image : elsewhere.images) image.name = "other " + image.name;
  const auto confirmed = Run({Model({1, 2, 5, 7}), Model(), elsewhere},
                             {Model(), Model(), Model()});
  ASSERT_TRUE(confirmed.ok());
  EXPECT_EQ(calls_, 2u);
  EXPECT_TRUE(confirmed->replaced);
  EXPECT_TRUE(confirmed->witnessed);
  EXPECT_THAT(confirmed->uncertain, IsEmpty());
  // The model of other photos stays, and no other one beside the first.
  ASSERT_THAT(confirmed->models, SizeIs(2));
  EXPECT_EQ(confirmed->models[1].images[0].name, elsewhere.images[0].name);
  EXPECT_EQ(confirmed->models[0].images[3].cam_from_world.translation.x(),
            Another(Model(), 1).images[3].cam_from_world.translation.x());
  EXPECT_TRUE(confirmed->attempts[0].kept);
  EXPECT_THAT(confirmed->attempts[0].problem, IsEmpty());
}

// Then nothing is left that could be trusted more than the first model.
TEST_F(ConfirmPosesTest, MostPhotosAreNotTakenOut) {
  const auto confirmed = Run({Model()}, {Model({1, 2, 3, 4, 5, 6})});
  ASSERT_TRUE(confirmed.ok());
  EXPECT_FALSE(confirmed->witnessed);
  EXPECT_THAT(confirmed->models, IsEmpty());
  EXPECT_THAT(confirmed->uncertain, SizeIs(6));
}

TEST_F(ConfirmPosesTest, WhatIsTooSmallOrTheSameSaysNothing) {
  Reconstruction small = Model();
  small.images.resize(kNumPhotos / 2 - 1);
  const auto confirmed = Run({Model()}, {small, Another(Model(), -2)});
  ASSERT_TRUE(confirmed.ok());
  ASSERT_THAT(confirmed->attempts, SizeIs(3));
  EXPECT_THAT(confirmed->attempts[0].problem, HasSubstr("too few"));
  EXPECT_THAT(confirmed->attempts[1].problem, HasSubstr("same model"));
  EXPECT_EQ(confirmed->attempts[2].name, "start by COLMAP");
  EXPECT_THAT(confirmed->attempts[2].problem, HasSubstr("same model"));
  EXPECT_EQ(colmaps_own_, 1);
  EXPECT_FALSE(confirmed->witnessed);
  EXPECT_THAT(confirmed->models, IsEmpty());
  EXPECT_THAT(confirmed->uncertain, IsEmpty());
}

TEST_F(ConfirmPosesTest, MappingsWithoutAModelAreTold) {
  problem_ = "mapper crashed";
  const auto crashed = Run({Model()}, {Reconstruction()});
  ASSERT_TRUE(crashed.ok());
  ASSERT_THAT(crashed->attempts, SizeIs(2));
  EXPECT_EQ(crashed->attempts[0].name, "start 2");
  EXPECT_EQ(crashed->attempts[0].problem, "mapper crashed");
  EXPECT_EQ(crashed->attempts[1].name, "start by COLMAP");
  problem_.clear();
  EXPECT_THAT(Run({Model()}, {Reconstruction()})->attempts[0].problem,
              HasSubstr("no model"));
}

TEST_F(ConfirmPosesTest, RepairsAreKeptWithTheirMapping) {
  Attempt repair;
  repair.name = "repair";
  repair.kept = true;
  repairs_ = {repair};
  const auto confirmed =
      Run({Model({1, 2, 5, 7})}, {Model(), Model(), Model()});
  ASSERT_TRUE(confirmed.ok());
  ASSERT_THAT(confirmed->attempts, SizeIs(4));
  EXPECT_TRUE(confirmed->attempts[0].kept);
  EXPECT_EQ(confirmed->attempts[1].name, "repair");
  EXPECT_TRUE(confirmed->attempts[1].kept);
  EXPECT_FALSE(confirmed->attempts[2].kept);
  EXPECT_FALSE(confirmed->attempts[3].kept);
  EXPECT_THAT(confirmed->attempts[3].problem, HasSubstr("not kept"));
}

TEST_F(ConfirmPosesTest, ThereIsAnEndToIt) {
  Models further;
  for (size_t i = 0; i < 8; ++i) {
    further.push_back(Model({i, (i + 2) % 10, (i + 5) % 10}));
  }
  ASSERT_TRUE(Run({Model()}, further).ok());
  EXPECT_EQ(calls_, 4u);
}

TEST_F(ConfirmPosesTest, NeitherTinyNorLargeModels) {
  Reconstruction tiny = Model();
  tiny.images.resize(2);
  EXPECT_THAT(Run({tiny}, {tiny})->attempts, IsEmpty());
  const Reconstruction large =
      SyntheticModel(static_cast<int>(kMostPhotosToConfirm) + 1, 4);
  EXPECT_THAT(Run({large}, {large})->attempts, IsEmpty());
  EXPECT_THAT(Run({}, {})->attempts, IsEmpty());
}

TEST_F(ConfirmPosesTest, ErrorsAreReturned) {
  const auto confirmed = ConfirmPoses(
      {Model()},
      0,
      [](const std::string&,
         std::optional<size_t>) -> StatusOr<std::optional<AttemptResult>> {
        return InterruptedError("stopped");
      });
  EXPECT_EQ(confirmed.status().code(), StatusCode::kInterrupted);
}

}  // namespace
}  // namespace freegs::sfm
