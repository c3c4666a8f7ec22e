// SPDX-License-Identifier: BSD-3-Clause
// The search follows its judge, and finds by itself which photos differ in
// exposure.

#include "splat/search/exposure_search.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/cancellation.h"
#include "splat/images/holdout.h"
#include "splat/train/checkpoint.h"
#include "tests/splat/training_fixture.h"

namespace freegs::splat {
namespace {

// Of training photos and of holdout photos, in dB.
std::string Gains(const ExposureChoice& choice) {
  return std::to_string(choice.with.training - choice.without.training) + ", " +
         std::to_string(choice.with.holdout - choice.without.holdout);
}

class ExposureSearchTest : public TrainingFixture {
 protected:
  static TrainerOptions Training() {
    TrainerOptions options = Options(300);
    options.budget = 640;
    return options;
  }

  StatusOr<ExposureChoice> Search(const FittedJudge& judge, int threads = 2) {
    ThreadPool pool(threads);
    TrainingImages images = ImagesOf(false, pool);
    return SearchExposure(search_,
                          Training(),
                          Start(),
                          2.0,
                          judge,
                          &images,
                          &pool,
                          &cancellation_);
  }

  // The two photos that judge, or the others, which are trained on.
  TrainingImages ImagesOf(bool judges, ThreadPool& pool) const {
    std::vector<View> views;
    for (size_t k = 0; k < views_.size(); ++k) {
      if ((k == 2 || k == 5) == judges) views.push_back(views_[k]);
    }
    auto images =
        TrainingImages::Load(views, folder_, TrainingImagesOptions(), pool);
    EXPECT_TRUE(images.ok()) << images.status().message();
    return std::move(images).value();
  }

  FittedJudge HoldoutJudge(ThreadPool* pool) {
    holdout_.emplace(ImagesOf(true, *pool));
    return [this, pool](const GaussianModel& model, int level) {
      return MeasureFittedHoldout(
          model, RenderOptions(), &*holdout_, *pool, level);
    };
  }

  // Makes the photos brighter from the first to the last.
  void RampExposure() {
    const auto last = static_cast<double>(photos_.size() - 1);
    for (size_t k = 0; k < photos_.size(); ++k) {
      const double factor = 0.5 + 0.5 * static_cast<double>(k) / last;
      for (size_t i = 0; i < photos_[k].size(); ++i) {
        uint8_t& value = photos_[k].data()[i];
        value = static_cast<uint8_t>(factor * value);
      }
      WritePhoto(k);
    }
  }

  // Makes two photos darker, the next two brighter, and so on.
  void VaryExposure() {
    for (size_t k = 0; k < photos_.size(); ++k) {
      const double factor = k / 2 % 2 == 0 ? 0.6 : 1.1;
      for (size_t i = 0; i < photos_[k].size(); ++i) {
        uint8_t& value = photos_[k].data()[i];
        value = static_cast<uint8_t>(std::min(255.0, factor * value + 8));
      }
      WritePhoto(k);
    }
  }

  ExposureSearchOptions search_{.level = 1, .min_trial_steps = 240};
  CancellationToken cancellation_;
  std::optional<TrainingImages> holdout_;
};

TEST_F(ExposureSearchTest, FollowsTheJudge) {
  // Exposures are the same, so those of neighbours change little.
  for (const double gain : {-3.0, 0.0, 0.9, 1.9, 4.0}) {
    int calls = 0;
    const auto choice =
        Search([&](const GaussianModel& model,
                   int level) -> StatusOr<std::optional<FittedPsnr>> {
          ++calls;
          EXPECT_EQ(level, 1);
          EXPECT_LE(model.size(), 160u);  // A quarter of the budget.
          return std::optional(FittedPsnr{22, 22 + gain});
        });
    ASSERT_TRUE(choice.ok()) << choice.status().message();
    EXPECT_EQ(choice->learn, gain > 1.4);
    EXPECT_NEAR(choice->with.training, choice->without.training, 0.4);
    EXPECT_EQ(choice->without.holdout, 22);
    EXPECT_EQ(choice->with.holdout, 22 + gain);
    EXPECT_EQ(calls, 1);
  }
}

TEST_F(ExposureSearchTest, PassesErrorsOn) {
  const auto unreadable = [](const GaussianModel&,
                             int) -> StatusOr<std::optional<FittedPsnr>> {
    return BadInputError("unreadable");
  };
  EXPECT_EQ(Search(unreadable).status().code(), StatusCode::kBadInput);
  // Where masks leave nothing to judge by, nothing is learnt.
  const auto silent = Search(
      [](const GaussianModel&, int) -> StatusOr<std::optional<FittedPsnr>> {
        return std::optional<FittedPsnr>();
      });
  ASSERT_TRUE(silent.ok()) << silent.status().message();
  EXPECT_FALSE(silent->learn);
  const auto fine = [](const GaussianModel&,
                       int) -> StatusOr<std::optional<FittedPsnr>> {
    return std::optional(FittedPsnr());
  };
  search_.min_gain_db = -1;
  EXPECT_EQ(Search(fine).status().code(), StatusCode::kInvalidArgument);
  search_.min_gain_db = 0.7;
  cancellation_.Cancel();
  EXPECT_EQ(Search(fine).status().code(), StatusCode::kInterrupted);
}

TEST_F(ExposureSearchTest, LearnsExposureOnlyWherePhotosDiffer) {
  ThreadPool pool(2);
  const auto same = Search(HoldoutJudge(&pool));
  ASSERT_TRUE(same.ok()) << same.status().message();
  EXPECT_FALSE(same->learn) << Gains(*same);
  VaryExposure();
  const auto different = Search(HoldoutJudge(&pool));
  ASSERT_TRUE(different.ok());
  EXPECT_TRUE(different->learn) << Gains(*different);
  // The same for another number of threads.
  EXPECT_EQ(*Search(HoldoutJudge(&pool), 1), *different);
}

// A new view is taken to have the exposure of the photos before and after it,
// not that of the whole scene.
TEST_F(ExposureSearchTest, LearnsAnExposureThatDrifts) {
  RampExposure();
  ThreadPool pool(2);
  const auto choice = Search(HoldoutJudge(&pool));
  ASSERT_TRUE(choice.ok()) << choice.status().message();
  EXPECT_TRUE(choice->learn) << Gains(*choice);
  TrainingImages images = ImagesOf(false, pool);
  Trainer trainer(Training(), Start(), 2.0, &images, &pool);
  trainer.KeepTo(*choice);
  ASSERT_TRUE(Finish(&trainer).ok());
  const auto of_scene =
      MeasureHoldout(trainer.model(), RenderOptions(), &*holdout_, pool);
  const auto of_neighbours = MeasureHoldout(trainer.model(),
                                            RenderOptions(),
                                            &*holdout_,
                                            pool,
                                            /*level=*/0,
                                            trainer.Exposures());
  ASSERT_TRUE(of_scene.ok() && of_neighbours.ok());
  EXPECT_GT(of_neighbours->mean_psnr, of_scene->mean_psnr + 0.5);
}

TEST_F(ExposureSearchTest, TrainingKeepsToTheChoice) {
  VaryExposure();
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  const auto make = [&](bool learn) {
    Trainer trainer(Training(), Start(), 2.0, &images, &pool);
    trainer.KeepTo({.learn = learn, .without = {}, .with = {}});
    return trainer;
  };
  Trainer whole = make(true);
  ASSERT_TRUE(Finish(&whole).ok());
  Trainer plain = make(false);
  ASSERT_TRUE(Finish(&plain).ok());
  EXPECT_NE(AllParameters(whole.model()), AllParameters(plain.model()));
  // Interrupted in the middle, restored in a trainer that was told nothing.
  Trainer first = make(true);
  while (first.iteration() < 150) ASSERT_TRUE(first.Step().ok());
  Trainer second(Training(), Start(), 2.0, &images, &pool);
  ASSERT_TRUE(second.Restore(first.Save()).ok());
  ASSERT_TRUE(second.exposure_choice().has_value());
  ASSERT_TRUE(Finish(&second).ok());
  EXPECT_EQ(AllParameters(second.model()), AllParameters(whole.model()));
  // A checkpoint of other photos.
  TrainingCheckpoint other = first.Save();
  other.history.colors.entries.pop_back();
  EXPECT_EQ(second.Restore(std::move(other)).code(), StatusCode::kBadInput);
}

}  // namespace
}  // namespace freegs::splat
