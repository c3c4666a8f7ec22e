// SPDX-License-Identifier: BSD-3-Clause
// What masks ignore has no part in training, nor in what is measured.

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "splat/images/holdout.h"
#include "splat/train/trainer.h"
#include "tests/splat/training_fixture.h"

namespace freegs::splat {
namespace {

using TrainerMasksTest = TrainingFixture;

// What the photos show where masks say to ignore them changes no byte of the
// result, and not what is measured either.
TEST_F(TrainerMasksTest, IgnoresWhatMasksSay) {
  const TemporaryFolder masks;
  ImageU8 mask(96, 72, 1, 255);
  for (int y = 20; y < 50; ++y) std::fill_n(mask.row(y) + 30, 35, uint8_t{0});
  for (const View& view : views_) {
    ASSERT_TRUE(WriteImage(masks.path() / (view.name + ".png"), mask).ok());
  }
  ThreadPool pool(2);
  std::vector<std::vector<float>> models;
  std::vector<double> psnr;
  for (const int garbage : {0, 1}) {
    for (size_t k = 0; k < views_.size(); ++k) {
      for (size_t i = 0; i < mask.size(); ++i) {
        if (mask.data()[i] != 0) continue;
        for (int c = 0; c < 3; ++c) {
          photos_[k].data()[3 * i + c] =
              static_cast<uint8_t>(RandomBits(garbage, k, 3 * i + c));
        }
      }
      WritePhoto(k);
    }
    StatusOr<TrainingImages> images = TrainingImages::Load(
        views_, folder_, {.num_levels = 1, .mask_folder = masks.path()}, pool);
    ASSERT_TRUE(images.ok()) << images.status().message();
    Trainer trainer(Options(60, DensificationMethod::kMiniSplatting),
                    Start(),
                    1.0,
                    &*images,
                    pool);
    ASSERT_TRUE(Finish(&trainer).ok());
    models.push_back(AllParameters(trainer.model()));
    const StatusOr<HoldoutReport> report =
        MeasureHoldout({.model = trainer.model(), .images = &*images}, pool);
    ASSERT_TRUE(report.ok()) << report.status().message();
    psnr.push_back(report->mean_psnr);
  }
  EXPECT_EQ(models[0], models[1]);
  EXPECT_EQ(psnr[0], psnr[1]);
}

// What a mask ignores asks for no Gaussians either.
TEST_F(TrainerMasksTest, NothingIsSplitForWhatMasksIgnore) {
  const TemporaryFolder masks;
  for (const View& view : views_) {
    ASSERT_TRUE(
        WriteImage(masks.path() / (view.name + ".png"), ImageU8(96, 72, 1, 0))
            .ok());
  }
  ThreadPool pool(2);
  for (const bool masked : {false, true}) {
    TrainingImagesOptions options;
    options.num_levels = 1;
    if (masked) options.mask_folder = masks.path();
    StatusOr<TrainingImages> images =
        TrainingImages::Load(views_, folder_, options, pool);
    ASSERT_TRUE(images.ok()) << images.status().message();
    Trainer trainer(NearPaperOptions(600), Start(), 1.0, &*images, pool);
    while (trainer.iteration() < 5) ASSERT_TRUE(trainer.Step().ok());
    const TrainingCheckpoint state = trainer.Save();
    const std::vector<float>& shares = state.statistics.max_dominant_share;
    ASSERT_FALSE(shares.empty());
    EXPECT_EQ(*std::ranges::max_element(shares) > 0, !masked);
  }
}

TEST_F(TrainerMasksTest, MeasuresOnlyWhatMasksLeave) {
  const TemporaryFolder masks;
  ThreadPool pool(1);
  // A photo that is wrong by a tenth on its right half.
  RenderedView shown =
      RenderView(truth_, views_[0].camera, views_[0].cam_from_world, {}, pool);
  photos_[0] = ToU8(shown.color);
  ImageU8 mask(96, 72, 1, 255);
  for (int y = 0; y < 72; ++y) {
    for (int x = 48; x < 96; ++x) {
      for (int c = 0; c < 3; ++c) {
        uint8_t& value = photos_[0](x, y, c);
        value = static_cast<uint8_t>(value < 128 ? value + 26 : value - 26);
      }
    }
    std::fill_n(mask.row(y), 48, uint8_t{0});
  }
  WritePhoto(0);
  views_.resize(1);
  ASSERT_TRUE(WriteImage(masks.path() / (views_[0].name + ".png"), mask).ok());
  const auto measure = [&](const std::filesystem::path& folder) {
    auto images = TrainingImages::Load(
        views_, folder_, {.num_levels = 1, .mask_folder = folder}, pool);
    return MeasureHoldout({.model = truth_, .images = &*images}, pool);
  };
  const double wrong = 10 * std::log10(255.0 * 255.0 / (26.0 * 26.0));
  EXPECT_NEAR(measure(masks.path())->mean_psnr, wrong, 0.01);
  EXPECT_NEAR(measure({})->mean_psnr, wrong + 10 * std::log10(2.0), 0.01);
  // Colours are compared on right halves only.
  const auto fitted = [&] {
    auto images = TrainingImages::Load(
        views_, folder_, {.num_levels = 1, .mask_folder = masks.path()}, pool);
    return MeasureFittedHoldout({.model = truth_, .images = &*images}, pool);
  };
  EXPECT_TRUE(fitted()->has_value());
  for (uint8_t& value : std::span(mask.data(), mask.size())) value ^= 255;
  ASSERT_TRUE(WriteImage(masks.path() / (views_[0].name + ".png"), mask).ok());
  ASSERT_TRUE(fitted().ok());
  EXPECT_FALSE(fitted()->has_value());
  // Nothing left to measure.
  ASSERT_TRUE(WriteImage(masks.path() / (views_[0].name + ".png"),
                         ImageU8(96, 72, 1, 0))
                  .ok());
  const auto nothing = measure(masks.path());
  ASSERT_TRUE(nothing.ok()) << nothing.status().message();
  EXPECT_EQ(nothing->views.size(), 0u);
  EXPECT_EQ(nothing->mean_psnr, 0);
  auto ignored = TrainingImages::Load(
      views_, folder_, {.num_levels = 1, .mask_folder = masks.path()}, pool);
  EXPECT_FALSE(MeasureHoldoutPsnr({.model = truth_, .images = &*ignored}, pool)
                   ->has_value());
}

}  // namespace
}  // namespace freegs::splat
