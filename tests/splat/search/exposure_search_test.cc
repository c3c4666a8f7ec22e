// SPDX-License-Identifier: BSD-3-Clause
// The search finds by itself which photos differ in exposure.

#include "splat/search/exposure_search.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/cancellation.h"
#include "core/io/image_io.h"
#include "splat/images/holdout.h"
#include "splat/train/checkpoint.h"
#include "tests/splat/training_fixture.h"
#include "tests/temporary_folder.h"

namespace freegs::splat {
namespace {

// What learnt exposure gains in dB, on the photos that the trial was trained on
// and on the others.
std::string Gains(const ExposureChoice& choice) {
  return std::to_string(choice.with.trained - choice.without.trained) + ", " +
         std::to_string(choice.with.held_out - choice.without.held_out);
}

class ExposureSearchTest : public TrainingFixture {
 protected:
  static TrainerOptions Training() {
    TrainerOptions options = Options(300);
    options.budget = 640;
    return options;
  }

  // With all photos, or with the folder of their masks. kUnusableResult when
  // the time is up.
  StatusOr<ExposureChoice> Search(int threads = 2,
                                  const std::filesystem::path& masks = {}) {
    ThreadPool pool(threads);
    auto images =
        TrainingImages::Load(views_, folder_, {.mask_folder = masks}, pool);
    EXPECT_TRUE(images.ok()) << images.status().message();
    FREEGS_ASSIGN_OR_RETURN(const std::optional<ExposureChoice> choice,
                            SearchExposure(search_,
                                           Training(),
                                           {Start(), 2.0, &*images},
                                           pool,
                                           &cancellation_));
    if (!choice) return UnusableResultError("the time is up");
    return *choice;
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
};

TEST_F(ExposureSearchTest, LearnsExposureOnlyWherePhotosDiffer) {
  const auto same = Search();
  ASSERT_TRUE(same.ok()) << same.status().message();
  EXPECT_FALSE(same->learn) << Gains(*same);
  VaryExposure();
  const auto different = Search();
  ASSERT_TRUE(different.ok());
  EXPECT_TRUE(different->learn) << Gains(*different);
  // Another number of threads leads to the same choice.
  EXPECT_EQ(*Search(1), *different);
  // The gain that it takes.
  const double gain = (different->with.trained - different->without.trained +
                       different->with.held_out - different->without.held_out) /
                      2;
  search_.min_gain_db = gain + 0.1;
  EXPECT_FALSE(Search()->learn);
  search_.min_gain_db = gain - 0.1;
  EXPECT_TRUE(Search()->learn);
}

TEST_F(ExposureSearchTest, EveryFifthPhotoByNameIsNotTrainedOn) {
  const ExposureChoice before = *Search();
  // These are photos 2 and 7. Only their right halves change.
  for (const size_t k : {2, 7}) {
    for (int y = 0; y < photos_[k].height(); ++y) {
      for (int x = photos_[k].width() / 2; x < photos_[k].width(); ++x) {
        for (int c = 0; c < 3; ++c) photos_[k](x, y, c) ^= 255;
      }
    }
    WritePhoto(k);
  }
  const ExposureChoice after = *Search();
  EXPECT_EQ(after.without.trained, before.without.trained);
  EXPECT_EQ(after.with.trained, before.with.trained);
  EXPECT_NE(after.without.held_out, before.without.held_out);
  // The order of the views does not matter to the choice of photos.
  std::reverse(views_.begin(), views_.end());
  std::reverse(photos_.begin(), photos_.end());
  EXPECT_NEAR(Search()->without.held_out, after.without.held_out, 0.5);
}

TEST_F(ExposureSearchTest, WithoutOthersNothingIsLearnt) {
  VaryExposure();
  const TemporaryFolder masks;
  ImageU8 left(96, 72, 1, 0);
  for (int y = 0; y < 72; ++y) std::fill_n(left.row(y), 48, uint8_t{255});
  for (const size_t k : {2, 7}) {
    ASSERT_TRUE(
        WriteImage(masks.path() / (views_[k].name + ".png"), left).ok());
  }
  const auto masked = Search(2, masks.path());
  ASSERT_TRUE(masked.ok()) << masked.status().message();
  EXPECT_FALSE(masked->learn);
  EXPECT_GT(masked->without.trained, 0);
  EXPECT_EQ(masked->without.held_out, 0);
  views_.resize(2);
  const auto few = Search();
  ASSERT_TRUE(few.ok()) << few.status().message();
  EXPECT_EQ(*few, ExposureChoice());
}

TEST_F(ExposureSearchTest, ReportsTheStepsOfTheTrial) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  search_ = {.level = 1, .trial_share = 0.1, .min_trial_steps = 30};
  std::vector<Progress> reports;
  const auto choice =
      SearchExposure(search_,
                     Training(),
                     {Start(), 2.0, &images},
                     pool,
                     &cancellation_,
                     [&](const Progress& p) { reports.push_back(p); });
  ASSERT_TRUE(choice.ok()) << choice.status().message();
  ASSERT_EQ(reports.size(), 3u);
  EXPECT_EQ(reports[0].done, 10);
  EXPECT_EQ(reports[2].done, 30);
  EXPECT_EQ(reports[2].total, 30);
  EXPECT_EQ(reports[2].step, "deciding about exposure");
}

TEST_F(ExposureSearchTest, ATrialThatFailsLearnsNothing) {
  VaryExposure();
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  TrainerOptions training = Training();
  training.learning_rates.sh_dc = 1e6;
  const auto choice =
      SearchExposure(search_, training, {Start(), 2.0, &images}, pool, nullptr);
  ASSERT_TRUE(choice.ok()) << choice.status().message();
  EXPECT_EQ(**choice, ExposureChoice());
}

TEST_F(ExposureSearchTest, EndsWhenTheTimeIsUp) {
  search_ = {.level = 1, .trial_share = 0.1, .min_trial_steps = 30};
  search_.deadline = std::chrono::steady_clock::now();
  EXPECT_EQ(Search().status().code(), StatusCode::kUnusableResult);
  search_.deadline = std::chrono::steady_clock::now() + std::chrono::hours(1);
  EXPECT_NE(*Search(), ExposureChoice());
}

// A trial does not densify less often than the training.
TEST_F(ExposureSearchTest, ShortIntervalsOfTrainingStayShort) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  search_ = {.level = 1, .trial_share = 0.25, .min_trial_steps = 60};
  const auto search = [&](int interval) {
    TrainerOptions training = Training();
    training.schedule.densify_interval = interval;
    return **SearchExposure(
        search_, training, {Start(), 2.0, &images}, pool, nullptr);
  };
  EXPECT_NE(search(5), search(10));
  EXPECT_EQ(search(12), search(10));
}

TEST_F(ExposureSearchTest, PassesErrorsOn) {
  search_.min_gain_db = -1;
  EXPECT_EQ(Search().status().code(), StatusCode::kInvalidArgument);
  search_ = {};
  search_.others_every = 1;
  EXPECT_EQ(Search().status().code(), StatusCode::kInvalidArgument);
  search_ = {};
  cancellation_.Cancel();
  EXPECT_EQ(Search().status().code(), StatusCode::kInterrupted);
  // The measurement at its end, too.
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  const GaussianModel model = Start();
  EXPECT_EQ(
      MeasureFittedHoldout(
          {.model = model, .images = &images, .cancellation = &cancellation_},
          pool)
          .status()
          .code(),
      StatusCode::kInterrupted);
}

// A new view is taken to have the exposure of the photos before and after it,
// not that of the whole scene.
TEST_F(ExposureSearchTest, LearnsAnExposureThatDrifts) {
  RampExposure();
  ThreadPool pool(2);
  TrainingImages all = Images(pool);
  const std::vector<size_t> kept = {0, 1, 3, 4, 6, 7};
  TrainingImages images = all.Subset(kept);
  TrainingImages holdout = all.Subset(std::vector<size_t>{2, 5});
  const auto choice = SearchExposure(
      search_, Training(), {Start(), 2.0, &images}, pool, nullptr);
  ASSERT_TRUE(choice.ok()) << choice.status().message();
  EXPECT_TRUE((*choice)->learn) << Gains(**choice);
  Trainer trainer(Training(), Start(), 2.0, &images, pool);
  trainer.SetExposureChoice(**choice);
  ASSERT_TRUE(Finish(&trainer).ok());
  const auto of_scene =
      MeasureHoldout({.model = trainer.model(), .images = &holdout}, pool);
  const auto of_neighbours = MeasureHoldout({.model = trainer.model(),
                                             .images = &holdout,
                                             .exposures = trainer.Exposures()},
                                            pool);
  ASSERT_TRUE(of_scene.ok() && of_neighbours.ok());
  EXPECT_GT(of_neighbours->mean_psnr, of_scene->mean_psnr + 0.5);
  // The PSNR alone is the same number.
  EXPECT_EQ(*MeasureHoldoutPsnr({.model = trainer.model(),
                                 .images = &holdout,
                                 .exposures = trainer.Exposures()},
                                pool),
            of_neighbours->mean_psnr);
}

TEST_F(ExposureSearchTest, TrainingKeepsToTheChoice) {
  VaryExposure();
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  const auto make = [&](bool learn) {
    Trainer trainer(Training(), Start(), 2.0, &images, pool);
    trainer.SetExposureChoice({.learn = learn, .without = {}, .with = {}});
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
  Trainer second(Training(), Start(), 2.0, &images, pool);
  ASSERT_TRUE(second.Restore(first.Save()).ok());
  ASSERT_TRUE(second.exposure_choice().has_value());
  ASSERT_TRUE(Finish(&second).ok());
  EXPECT_EQ(AllParameters(second.model()), AllParameters(whole.model()));
  // A checkpoint of other photos.
  TrainingCheckpoint other = first.Save();
  other.history.colors.entries.pop_back();
  const Status status = second.Restore(std::move(other));
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_NE(status.message().find("7 photos, but the training has 8;"),
            std::string::npos);
}

}  // namespace
}  // namespace freegs::splat
