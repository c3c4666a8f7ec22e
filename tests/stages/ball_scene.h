// SPDX-License-Identifier: BSD-3-Clause
// A scene whose truth is known to the last Gaussian.

#ifndef FREEGS_TESTS_STAGES_BALL_SCENE_H_
#define FREEGS_TESTS_STAGES_BALL_SCENE_H_

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "core/cancellation.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/parallel.h"
#include "core/random.h"
#include "splat/render/renderer.h"
#include "stages/evaluation/evaluation_context.h"
#include "stages/evaluation/ground_truth.h"
#include "stages/scene/workspace_scene.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {

// Three balls of Gaussians in a row, the true objects 1, 2 and 3, seen from
// all around.
class BallScene : public testing::Test {
 protected:
  static constexpr int kPerBall = 300;
  static constexpr double kRadius = 0.5;
  static constexpr double kSigma = 0.06;  // Boxes reach one sigma further.

  void SetUp() override {
    folder_ = temporary_.path();
    ASSERT_TRUE(CreateFolders(folder_ / "test/images").ok());
    ASSERT_TRUE(CreateFolders(folder_ / "gt/instance").ok());
    MakeBalls();
    truth_.folder = folder_;
    truth_.complete = true;
    for (int i = 0; i < 10; ++i) {
      const std::string number = std::to_string(i);
      truth_.cameras.train.push_back(
          MakeView("frame_" + number + ".jpg", 0.6 * i));
      if (i % 4 == 0) {
        truth_.cameras.test.push_back(
            MakeView("test_" + number + ".png", 0.6 * i + 0.3));
      }
    }
    for (const View& view : truth_.cameras.test) {
      const splat::RenderedView picture = splat::RenderView(
          true_model_, view.camera, view.cam_from_world, {}, pool_);
      truth_.photos[view.name] = folder_ / "test/images" / view.name;
      ASSERT_TRUE(
          WriteImage(truth_.photos[view.name], ToU8(picture.color)).ok());
      const Image<int32_t> labels = splat::RenderLabels(
          true_model_, view.camera, view.cam_from_world, {}, pool_, labels_);
      ImageU16 ids(labels.width(), labels.height(), 1);
      for (size_t i = 0; i < ids.size(); ++i) {
        ids.data()[i] = static_cast<uint16_t>(labels.data()[i] + 1);
      }
      truth_.masks[view.name] = {{folder_ / "gt/instance" / view.name, 0}};
      ASSERT_TRUE(WriteLabels(truth_.masks[view.name][0].path, ids).ok());
    }
  }

  void MakeBalls() {
    true_model_.Resize(3 * kPerBall);
    for (int ball = 0; ball < 3; ++ball) {
      TrueObject object;
      object.id = ball + 1;
      object.label = "ball " + std::to_string(ball + 1);
      const Eigen::Vector3d centre(1.5 * (ball - 1), 0, 0);
      object.aabb = {centre - Eigen::Vector3d::Constant(kRadius + kSigma),
                     centre + Eigen::Vector3d::Constant(kRadius + kSigma)};
      truth_.objects.push_back(object);
      for (int k = 0; k < kPerBall; ++k) {
        const size_t i = static_cast<size_t>(ball) * kPerBall + k;
        RandomStream random(1, i);
        const Eigen::Vector3d direction(
            random.Normal(), random.Normal(), random.Normal());
        const Eigen::Vector3d mean = centre + kRadius * direction.normalized();
        for (int axis = 0; axis < 3; ++axis) {
          true_model_.means[3 * i + axis] = static_cast<float>(mean[axis]);
          true_model_.log_scales[3 * i + axis] =
              static_cast<float>(std::log(kSigma));
          true_model_.sh_dc[3 * i + axis] =
              static_cast<float>(2 * random.Uniform() - 1);
        }
        true_model_.rotations[4 * i] = 1;
        true_model_.opacity_logits[i] = 4;
        labels_.push_back(ball);
      }
    }
  }

  static View MakeView(const std::string& name, double angle) {
    const Eigen::Vector3d eye(5 * std::cos(angle),
                              5 * std::sin(angle),
                              1 + 0.5 * std::sin(3 * angle));
    const Eigen::Vector3d z = -eye.normalized();
    const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d rotation;
    rotation << x.transpose(), z.cross(x).transpose(), z.transpose();
    View view;
    view.name = name;
    view.camera = {96, 72, 90, 90, 48, 36};
    view.cam_from_world.rotation = Eigen::Quaterniond(rotation);
    view.cam_from_world.translation = -rotation * eye;
    return view;
  }

  // The truth as a reconstruction in a world of its own would have it.
  WorkspaceScene MakeScene() const {
    const Sim3d scene_from_truth = Inverse(truth_from_scene_);
    WorkspaceScene scene;
    scene.model = true_model_;
    for (size_t i = 0; i < scene.model.size(); ++i) {
      const Eigen::Vector3d mean =
          scene_from_truth * Eigen::Vector3d(true_model_.means[3 * i],
                                             true_model_.means[3 * i + 1],
                                             true_model_.means[3 * i + 2]);
      const float* q = true_model_.rotations.data() + 4 * i;
      const Eigen::Quaterniond turned =
          scene_from_truth.rotation *
          Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
      scene.model.rotations[4 * i] = static_cast<float>(turned.w());
      for (int axis = 0; axis < 3; ++axis) {
        scene.model.means[3 * i + axis] = static_cast<float>(mean[axis]);
        scene.model.rotations[4 * i + 1 + axis] =
            static_cast<float>(turned.vec()[axis]);
        scene.model.log_scales[3 * i + axis] +=
            static_cast<float>(std::log(scene_from_truth.scale));
      }
    }
    for (const View& view : truth_.cameras.train) {
      View moved = view;
      moved.cam_from_world =
          TransformCamera(scene_from_truth, view.cam_from_world);
      scene.train.push_back(moved);
    }
    return scene;
  }

  // Refers to the scene and to members of this fixture.
  EvaluationContext Context(const WorkspaceScene& scene) {
    return {.scene = scene,
            .truth = truth_,
            .truth_from_scene = truth_from_scene_,
            .cancellation = cancellation_,
            .pool = pool_};
  }

  ThreadPool pool_{2};
  CancellationToken cancellation_;
  TemporaryFolder temporary_;
  std::filesystem::path folder_;
  GroundTruth truth_;
  splat::GaussianModel true_model_;
  std::vector<int32_t> labels_;
  Sim3d truth_from_scene_{0.4,
                          Eigen::Quaterniond(Eigen::AngleAxisd(
                              1.1, Eigen::Vector3d(1, 2, 3).normalized())),
                          {3, -2, 1}};
};

}  // namespace freegs::stages

#endif  // FREEGS_TESTS_STAGES_BALL_SCENE_H_
