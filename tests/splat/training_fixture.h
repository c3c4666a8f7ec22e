// SPDX-License-Identifier: BSD-3-Clause
// Photos of a small known scene on disk, and a trainer's options for them.

#ifndef FREEGS_TESTS_SPLAT_TRAINING_FIXTURE_H_
#define FREEGS_TESTS_SPLAT_TRAINING_FIXTURE_H_

#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "splat/train/trainer.h"
#include "tests/splat/test_scene.h"
#include "tests/temporary_folder.h"

namespace freegs::splat {

// A temporary folder of rendered views of a known model.
class TrainingFixture : public testing::Test {
 protected:
  void SetUp() override {
    truth_ = RandomSceneModel(60, 0, 21);
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
      photos_.push_back(ToU8(rendered.color));
      WritePhoto(k);
    }
  }
  void WritePhoto(size_t k) const {
    ASSERT_TRUE(WriteImage(folder_ / views_[k].name, photos_[k]).ok());
  }

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

  static TrainerOptions Options(
      int iterations,
      DensificationMethod method = DensificationMethod::kGradient) {
    TrainerOptions options;
    options.schedule.iterations = iterations;
    options.schedule.method = method;
    options.schedule.sh_degree = 1;
    options.schedule.densify_interval = 20;
    options.learning_rates.mean_decay_steps = iterations;
    options.seed = 5;
    return options;
  }

  // Mini-Splatting nearer to its paper: colour waits for the simplification.
  static TrainerOptions NearPaperOptions(int iterations) {
    TrainerOptions options =
        Options(iterations, DensificationMethod::kMiniSplatting);
    options.schedule.sh_start = options.schedule.simplify_at;
    options.mini_splatting.blur_split_share = 1.0 / 5000;
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

  // Steps until the end or an error.
  static Status Finish(Trainer* trainer) {
    Status status;
    while (!trainer->done() && status.ok()) status = trainer->Step().status();
    return status;
  }

  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
  GaussianModel truth_;
  std::vector<View> views_;
  std::vector<ImageU8> photos_;
};

}  // namespace freegs::splat

#endif  // FREEGS_TESTS_SPLAT_TRAINING_FIXTURE_H_
