// SPDX-License-Identifier: BSD-3-Clause

#include "splat/density/mini_splatting.h"

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <optional>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "splat/images/holdout.h"
#include "tests/splat/same_parameters.h"
#include "tests/splat/training_fixture.h"
#include "tests/temporary_folder.h"

namespace freegs::splat {
namespace {

using ::testing::HasSubstr;

class MiniSplattingTest : public TrainingFixture {
 protected:
  MiniSplattingTest() : pool_(2) {}
  void SetUp() override {
    TrainingFixture::SetUp();
    images_.emplace(Images(pool_));
    context_.images = &*images_;
    context_.scene_extent = 2;
    context_.seed = 4;
    context_.iteration = 100;
    context_.rasterizer = &rasterizer_;
    context_.pool = &pool_;
    // Two that no view shows, with moments of their own all around.
    model_ = truth_;
    model_.means[2] = -100;
    model_.means[5] = -100;
    adam_.Reset(model_);
    AdamState state = adam_.state();
    state.steps = 9;
    std::iota(state.first_moments.opacity_logits.begin(),
              state.first_moments.opacity_logits.end(),
              1.0f);
    adam_.set_state(state);
  }

  bool MomentsAreZero() const {
    const std::vector<float>& m = adam_.state().first_moments.opacity_logits;
    return std::all_of(m.begin(), m.end(), [](float v) { return v == 0; });
  }

  // Its moments say which Gaussian of model_ each was.
  void ExpectSubset(const GaussianModel& kept) const {
    ASSERT_EQ(kept.size(), adam_.size());
    for (size_t k = 0; k < kept.size(); ++k) {
      const auto i = static_cast<size_t>(
          adam_.state().first_moments.opacity_logits[k] - 1);
      ASSERT_LT(i, model_.size());
      EXPECT_EQ(kept.means[3 * k], model_.means[3 * i]);
      EXPECT_EQ(kept.log_scales[3 * k], model_.log_scales[3 * i]);
      EXPECT_GT(i, 1u);  // Those two are not seen.
    }
  }

  ThreadPool pool_;
  std::optional<TrainingImages> images_;
  Rasterizer rasterizer_;
  MiniSplattingContext context_;
  GaussianModel model_;
  Adam adam_;
};

TEST_F(MiniSplattingTest, ImportanceOverAllViews) {
  for (const ImportanceMetric metric :
       {ImportanceMetric::kIndoor, ImportanceMetric::kOutdoor}) {
    const std::vector<float> importance =
        ComputeImportance(context_, model_, metric).value();
    ASSERT_EQ(importance.size(), model_.size());
    EXPECT_EQ(importance[0], 0);
    EXPECT_EQ(importance[1], 0);
    EXPECT_GT(*std::max_element(importance.begin(), importance.end()), 0);
  }
}

// Importance is about what is rendered, not about what photos show. So photos
// that do not fit in memory are not read again for it.
TEST_F(MiniSplattingTest, ImportanceReadsPhotosOnlyForTheirMasks) {
  const std::vector<float> expected =
      ComputeImportance(context_, model_, ImportanceMetric::kIndoor).value();
  const TemporaryFolder masks;
  const std::filesystem::path kMaskFolders[] = {{}, masks.path()};
  std::vector<TrainingImages> loaded;
  for (const std::filesystem::path& mask_folder : kMaskFolders) {
    auto images = TrainingImages::Load(
        views_, folder_, {.max_bytes = 0, .mask_folder = mask_folder}, pool_);
    ASSERT_TRUE(images.ok()) << images.status().message();
    loaded.push_back(std::move(images).value());
  }
  for (const View& view : views_) std::filesystem::remove(folder_ / view.name);
  context_.images = &loaded[0];
  const auto importance =
      ComputeImportance(context_, model_, ImportanceMetric::kIndoor);
  ASSERT_TRUE(importance.ok()) << importance.status().message();
  EXPECT_EQ(*importance, expected);
  // A mask comes with its photo.
  context_.images = &loaded[1];
  EXPECT_EQ(ComputeImportance(context_, model_, ImportanceMetric::kIndoor)
                .status()
                .code(),
            StatusCode::kBadInput);
}

TEST_F(MiniSplattingTest, SimplifyKeepsParametersAndMoments) {
  GaussianModel model = model_;
  const auto summary = Simplify(MiniSplattingOptions(),
                                20,
                                ImportanceMetric::kIndoor,
                                context_,
                                &model,
                                &adam_);
  ASSERT_TRUE(summary.ok()) << summary.status().message();
  EXPECT_EQ(summary->before, 60u);
  EXPECT_EQ(summary->after, 20u);
  EXPECT_EQ(model.size(), 20u);
  ExpectSubset(model);
}

TEST_F(MiniSplattingTest, SimplifyWithoutABudgetKeepsHalf) {
  GaussianModel model = model_;
  const auto summary = Simplify(MiniSplattingOptions(),
                                0,
                                ImportanceMetric::kOutdoor,
                                context_,
                                &model,
                                &adam_);
  ASSERT_TRUE(summary.ok());
  // Half of those that have any importance: not the two behind.
  EXPECT_LE(summary->after, 29u);
  EXPECT_GT(summary->after, 5u);
  EXPECT_EQ(model.size(), summary->after);
  ExpectSubset(model);
}

TEST_F(MiniSplattingTest, PruneRemovesTheTail) {
  GaussianModel model = model_;
  const auto summary = PruneByImportance(MiniSplattingOptions(),
                                         0,
                                         ImportanceMetric::kIndoor,
                                         context_,
                                         &model,
                                         &adam_);
  ASSERT_TRUE(summary.ok());
  EXPECT_LE(summary->after, 58u);
  EXPECT_GT(summary->after, 20u);
  ExpectSubset(model);
}

TEST_F(MiniSplattingTest, PruneKeepsTheBudget) {
  const Adam before = adam_;
  const auto prune = [&](int64_t budget) {
    GaussianModel model = model_;
    adam_ = before;
    const auto summary = PruneByImportance(MiniSplattingOptions(),
                                           budget,
                                           ImportanceMetric::kIndoor,
                                           context_,
                                           &model,
                                           &adam_);
    EXPECT_TRUE(summary.ok());
    EXPECT_EQ(summary->before, 60u);
    EXPECT_EQ(summary->after, model.size());
    ExpectSubset(model);
    return model;
  };
  // No Gaussian left out is more important than one kept.
  std::vector<float> sorted =
      ComputeImportance(context_, model_, ImportanceMetric::kIndoor).value();
  const std::vector<float> importance = sorted;
  std::sort(sorted.rbegin(), sorted.rend());
  for (const int64_t budget : {1, 15}) {
    EXPECT_EQ(prune(budget).size(), static_cast<size_t>(budget));
    for (const float m : adam_.state().first_moments.opacity_logits) {
      EXPECT_GE(importance[static_cast<size_t>(m - 1)], sorted[budget - 1]);
    }
  }
  // The share that goes in any case is enough for a large one.
  const GaussianModel unlimited = prune(0);
  EXPECT_TRUE(SameParameters(prune(60), unlimited));
  EXPECT_TRUE(SameParameters(prune(unlimited.size()), unlimited));
}

TEST_F(MiniSplattingTest, DepthPointsShowTheScene) {
  GaussianModel model = model_;
  MiniSplattingOptions options;
  options.dense_factor = 2;
  // 7/9 of twice the budget, rounded up.
  const auto summary =
      ReinitializeFromDepth(options, 2571, context_, &model, &adam_);
  ASSERT_TRUE(summary.ok()) << summary.status().message();
  EXPECT_EQ(summary->before, 60u);
  EXPECT_EQ(summary->after, 4000u);
  EXPECT_TRUE(MomentsAreZero());
  EXPECT_EQ(adam_.size(), 4000u);
  EXPECT_TRUE(model.AllFinite());
  // Opaque, the points picture the scene they came from.
  const auto psnr = [&](float logit) {
    for (float& value : model.opacity_logits) value = logit;
    const StatusOr<HoldoutReport> report =
        MeasureHoldout({.model = model, .images = &*images_}, pool_);
    EXPECT_TRUE(report.ok());
    return report->mean_psnr;
  };
  EXPECT_GT(psnr(3), psnr(-15) + 4);
}

TEST_F(MiniSplattingTest, DepthPointsHaveNoneOfThePhotosExposure) {
  const auto restart = [&] {
    GaussianModel model = model_;
    EXPECT_TRUE(ReinitializeFromDepth({}, 321, context_, &model, &adam_).ok());
    return model.sh_dc;
  };
  const std::vector<float> plain = restart();
  PhotoColors colors;
  context_.colors = &colors;
  EXPECT_EQ(restart(), plain);  // Nothing was learnt.
  colors.entries.resize(images_->size());
  for (PhotoColors::Entry& entry : colors.entries) entry.color.values[0] = 2;
  const std::vector<float> darker = restart();
  ASSERT_EQ(darker.size(), plain.size());
  for (size_t i = 0; i < plain.size(); i += 3) {
    // A channel begins with 1/255 at least.
    const float half = (plain[i] * kShC0 + 0.5f) / 2;
    EXPECT_NEAR(darker[i] * kShC0 + 0.5f, std::max(half, 1 / 255.0f), 1e-5);
    EXPECT_EQ(darker[i + 1], plain[i + 1]);
  }
}

TEST_F(MiniSplattingTest, DependsOnSeedAndIterationOnly) {
  MiniSplattingOptions options;
  const auto run = [&](uint64_t seed, int64_t iteration, int threads) {
    ThreadPool pool(threads);
    context_.seed = seed;
    context_.iteration = iteration;
    context_.pool = &pool;
    GaussianModel model = model_;
    Adam adam = adam_;
    EXPECT_TRUE(
        ReinitializeFromDepth(options, 321, context_, &model, &adam).ok());
    EXPECT_TRUE(
        Simplify(
            options, 200, ImportanceMetric::kIndoor, context_, &model, &adam)
            .ok());
    return model;
  };
  const GaussianModel once = run(1, 10, 1);
  EXPECT_TRUE(SameParameters(run(1, 10, 3), once));
  EXPECT_FALSE(SameParameters(run(2, 10, 1), once));
  EXPECT_FALSE(SameParameters(run(1, 11, 1), once));
}

TEST_F(MiniSplattingTest, NothingToSee) {
  GaussianModel model = model_;
  for (size_t i = 0; i < model.size(); ++i) model.means[3 * i + 2] = -100;
  const GaussianModel before = model;
  const auto depth = ReinitializeFromDepth(
      MiniSplattingOptions(), 0, context_, &model, &adam_);
  ASSERT_TRUE(depth.ok());
  EXPECT_EQ(depth->after, 60u);
  EXPECT_TRUE(SameParameters(model, before));
  EXPECT_FALSE(MomentsAreZero());
  const Status status = Simplify(MiniSplattingOptions(),
                                 9,
                                 ImportanceMetric::kIndoor,
                                 context_,
                                 &model,
                                 &adam_)
                            .status();
  EXPECT_EQ(status.code(), StatusCode::kUnusableResult);
  EXPECT_THAT(status.message(), HasSubstr("none of the 60 Gaussians"));
  EXPECT_EQ(PruneByImportance(MiniSplattingOptions(),
                              9,
                              ImportanceMetric::kIndoor,
                              context_,
                              &model,
                              &adam_)
                .status()
                .code(),
            StatusCode::kUnusableResult);
}

TEST_F(MiniSplattingTest, CancelledOperationsChangeNothing) {
  CancellationToken cancelled;
  cancelled.Cancel();
  context_.cancellation = &cancelled;
  const MiniSplattingOptions options;
  constexpr auto kMetric = ImportanceMetric::kIndoor;
  GaussianModel model = model_;
  for (const auto& result :
       {ReinitializeFromDepth(options, 20, context_, &model, &adam_),
        Simplify(options, 20, kMetric, context_, &model, &adam_),
        PruneByImportance(options, 20, kMetric, context_, &model, &adam_)}) {
    EXPECT_EQ(result.status().code(), StatusCode::kInterrupted);
  }
  EXPECT_EQ(AllParameters(model), AllParameters(model_));
  EXPECT_EQ(adam_.size(), model_.size());
  EXPECT_FALSE(MomentsAreZero());
}

TEST(NumDepthPoints, FillsTheBudgetWithinTheLimits) {
  MiniSplattingOptions options;
  options.dense_factor = 2;
  EXPECT_EQ(NumDepthPoints(options, 4500, 0, 1), 7000u);
  EXPECT_EQ(NumDepthPoints(options, 0, 10, 3200), 100u);
  EXPECT_EQ(NumDepthPoints(options, 0, 1000, 3200), 1000u);
  EXPECT_EQ(NumDepthPoints(options, 0, 1000, uint64_t{1} << 40), 3500000u);
}

TEST(MiniSplattingOptions, CheckRefusesValuesOutOfRange) {
  EXPECT_TRUE(MiniSplattingOptions().Check().ok());
  EXPECT_FALSE(MiniSplattingOptions{.blur_split_share = 1}.Check().ok());
  EXPECT_FALSE(MiniSplattingOptions{.dense_factor = 0}.Check().ok());
  EXPECT_FALSE(MiniSplattingOptions{.simplify_keep = 0}.Check().ok());
  EXPECT_FALSE(MiniSplattingOptions{.prune_importance_share = 1}.Check().ok());
}

}  // namespace
}  // namespace freegs::splat
