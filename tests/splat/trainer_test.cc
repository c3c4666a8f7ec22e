// SPDX-License-Identifier: BSD-3-Clause

#include "splat/trainer.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

#include "core/image_io.h"
#include "splat/holdout.h"
#include "tests/splat/test_scene.h"

namespace freegs::splat {
namespace {

namespace fs = std::filesystem;

// A folder of rendered views of a known model, removed at the end.
class TrainerTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern =
        (fs::temp_directory_path() / "freegs_trainer_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
    truth_ = RandomModel(60, 0, 21);
    for (float& logit : truth_.opacity_logits) logit = 3;
    ThreadPool pool(2);
    for (int k = 0; k < 8; ++k) {
      View view;
      view.name = "view" + std::to_string(k) + ".png";
      view.camera = TestCamera(96, 72);
      Rigid3d orbit;
      orbit.rotation = Eigen::Quaterniond(
          Eigen::AngleAxisd(0.12 * (k - 3.5), Eigen::Vector3d::UnitY()));
      view.cam_from_world = TestPose() * orbit;
      views_.push_back(view);
      const RenderedView rendered = RenderView(
          truth_, view.camera, view.cam_from_world, RenderOptions(), pool);
      ASSERT_TRUE(WriteImage(folder_ / view.name, ToU8(rendered.color)).ok());
    }
  }
  void TearDown() override { fs::remove_all(folder_); }

  TrainingImages Images(ThreadPool& pool) const {
    StatusOr<TrainingImages> images =
        TrainingImages::Load(views_, folder_, TrainingImagesOptions(), pool);
    EXPECT_TRUE(images.ok()) << images.status().message();
    return std::move(images).value();
  }

  // The truth with its colours, sizes and positions disturbed.
  GaussianModel Start() const {
    GaussianModel model = truth_;
    for (size_t i = 0; i < model.means.size(); ++i) {
      model.means[i] += static_cast<float>(0.03 * RandomNormal(1, 1, i));
      model.sh_dc[i] = 0.3f;
      model.log_scales[i] = -2.5f;
    }
    for (float& logit : model.opacity_logits) logit = -1;
    return model;
  }

  static TrainerOptions Options(int iterations) {
    TrainerOptions options;
    options.schedule.iterations = iterations;
    options.schedule.sh_degree = 1;
    options.learning_rates.mean_decay_steps = iterations;
    options.schedule.densify_interval = 20;
    options.seed = 5;
    return options;
  }

  static std::vector<float> AllParameters(const GaussianModel& model) {
    std::vector<float> all;
    for (const Parameter parameter : kAllParameters) {
      const std::vector<float>& array = ParameterArray(model, parameter);
      all.insert(all.end(), array.begin(), array.end());
    }
    return all;
  }

  fs::path folder_;
  GaussianModel truth_;
  std::vector<View> views_;
};

TEST_F(TrainerTest, LearnsTheScene) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  Trainer trainer(Options(300), Start(), 2.0, &images, &pool);
  const StatusOr<HoldoutReport> before =
      MeasureHoldout(trainer.model(), RenderOptions(), &images, pool);
  ASSERT_TRUE(before.ok());
  while (!trainer.done()) ASSERT_TRUE(trainer.Step().ok());
  const StatusOr<HoldoutReport> after =
      MeasureHoldout(trainer.model(), RenderOptions(), &images, pool);
  ASSERT_TRUE(after.ok());
  EXPECT_GT(after->mean_psnr, before->mean_psnr + 6);
  EXPECT_EQ(trainer.model().sh_degree, 1);
}

TEST_F(TrainerTest, SameBytesForAnyNumberOfThreadsAndAcrossARestore) {
  std::vector<float> undisturbed;
  for (const int threads : {1, 3}) {
    ThreadPool pool(threads);
    TrainingImages images = Images(pool);
    Trainer trainer(Options(120), Start(), 2.0, &images, &pool);
    while (!trainer.done()) ASSERT_TRUE(trainer.Step().ok());
    if (undisturbed.empty()) undisturbed = AllParameters(trainer.model());
    EXPECT_EQ(AllParameters(trainer.model()), undisturbed);
  }
  for (const int stop : {1, 37, 60, 119}) {
    ThreadPool pool(2);
    TrainingImages images = Images(pool);
    std::string saved;
    {
      Trainer trainer(Options(120), Start(), 2.0, &images, &pool);
      while (trainer.iteration() < stop) ASSERT_TRUE(trainer.Step().ok());
      saved = SerializeCheckpoint(trainer.Save());
    }
    StatusOr<TrainingCheckpoint> checkpoint = ParseCheckpoint(saved);
    ASSERT_TRUE(checkpoint.ok());
    Trainer trainer(Options(120), Start(), 2.0, &images, &pool);
    ASSERT_TRUE(trainer.Restore(std::move(checkpoint).value()).ok());
    while (!trainer.done()) ASSERT_TRUE(trainer.Step().ok());
    EXPECT_EQ(AllParameters(trainer.model()), undisturbed) << "stop " << stop;
  }
}

TEST_F(TrainerTest, RefusesACheckpointThatDoesNotFit) {
  ThreadPool pool(1);
  TrainingImages images = Images(pool);
  Trainer trainer(Options(10), Start(), 2.0, &images, &pool);
  TrainingCheckpoint checkpoint = trainer.Save();
  checkpoint.adam.first_moments.Resize(3);
  EXPECT_EQ(trainer.Restore(checkpoint).code(), StatusCode::kBadInput);
  checkpoint = trainer.Save();
  checkpoint.iteration = 11;
  EXPECT_EQ(trainer.Restore(checkpoint).code(), StatusCode::kBadInput);
}

TEST_F(TrainerTest, SaysSoWhenTheNumbersAreNotFinite) {
  ThreadPool pool(1);
  TrainingImages images = Images(pool);
  GaussianModel start = Start();
  start.sh_dc[0] = NAN;
  Trainer trainer(Options(10), start, 2.0, &images, &pool);
  Status status;
  while (!trainer.done() && status.ok()) status = trainer.Step().status();
  EXPECT_EQ(status.code(), StatusCode::kUnusableResult);
}

TEST(TrainerOptions, Check) {
  EXPECT_TRUE(TrainerOptions().Check().ok());
  TrainerOptions options;
  options.schedule.iterations = 0;
  EXPECT_FALSE(options.Check().ok());
  options = TrainerOptions();
  options.schedule.sh_degree = 4;
  EXPECT_FALSE(options.Check().ok());
  options = TrainerOptions();
  options.schedule.resolution_steps = {0.5, 0.2};
  EXPECT_FALSE(options.Check().ok());
}

}  // namespace
}  // namespace freegs::splat
