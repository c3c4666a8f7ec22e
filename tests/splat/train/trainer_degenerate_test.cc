// SPDX-License-Identifier: BSD-3-Clause
// Inputs that are hardly scenes: training ends with finite numbers, or says
// clearly why there is no result.

#include <algorithm>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "splat/scene/initialization.h"
#include "splat/train/trainer.h"
#include "tests/splat/training_fixture.h"

namespace freegs::splat {
namespace {

class TrainerDegenerateTest : public TrainingFixture {
 protected:
  using Points = std::vector<Eigen::Vector3d>;

  static GaussianModel FromPoints(const Points& points) {
    const std::vector<std::array<uint8_t, 3>> colors(points.size(),
                                                     {90, 120, 200});
    StatusOr<GaussianModel> model = InitializeFromPoints(points, colors, 2.0);
    EXPECT_TRUE(model.ok());
    return std::move(model).value();
  }

  // Trains with each method; the status of each must be as asked for.
  void Expect(const GaussianModel& start, bool ok, int64_t budget = 300) {
    ThreadPool pool(2);
    for (const DensificationMethod method :
         {DensificationMethod::kNone,
          DensificationMethod::kGradient,
          DensificationMethod::kMiniSplatting}) {
      for (const int iterations : {3, 150}) {
        TrainingImages images = Images(pool);
        TrainerOptions options = Options(iterations, method);
        options.budget = budget;
        ASSERT_TRUE(options.Check().ok());
        Trainer trainer(options, start, 2.0, &images, pool);
        const Status status = Finish(&trainer);
        const std::string trace =
            "method " + std::to_string(static_cast<int>(method)) + ", " +
            std::to_string(iterations) + " iterations: " + status.message();
        EXPECT_TRUE(status.ok() || !ok) << trace;
        if (!status.ok()) {
          EXPECT_EQ(status.code(), StatusCode::kUnusableResult) << trace;
          EXPECT_NE(status.message().find("check"), std::string::npos) << trace;
        }
        EXPECT_TRUE(trainer.model().AllFinite()) << trace;
      }
    }
  }
};

TEST_F(TrainerDegenerateTest, OnePoint) {
  Expect(FromPoints({Eigen::Vector3d::Zero()}), true);
}

TEST_F(TrainerDegenerateTest, CoincidentPoints) {
  Expect(FromPoints(Points(40, Eigen::Vector3d(0.1, 0.2, 0.3))), true);
}

TEST_F(TrainerDegenerateTest, CoplanarPoints) {
  Points points;
  for (int k = 0; k < 100; ++k) {
    points.emplace_back(0.3 * (k % 10) - 1.5, 0.3 * (k / 10) - 1.5, 0.5);
  }
  Expect(FromPoints(points), true);
}

TEST_F(TrainerDegenerateTest, CollinearPoints) {
  Points points;
  for (int k = 0; k < 30; ++k) points.emplace_back(0.1 * k - 1.5, 0, 0);
  Expect(FromPoints(points), true);
}

TEST_F(TrainerDegenerateTest, CameraInsideAGaussian) {
  GaussianModel model = Start();
  // One around everything, one around a single camera.
  for (int axis = 0; axis < 3; ++axis) {
    model.log_scales[axis] = 3;
    const Eigen::Vector3d centre = CameraCentre(views_[2].cam_from_world);
    model.means[3 + axis] = static_cast<float>(centre[axis]);
    model.log_scales[3 + axis] = 0;
  }
  Expect(model, true);
}

TEST_F(TrainerDegenerateTest, PointsBehindAllCameras) {
  Points points;
  for (int k = 0; k < 20; ++k) points.emplace_back(0.1 * k - 1, 0, -50);
  Expect(FromPoints(points), false);
}

TEST_F(TrainerDegenerateTest, PointsFarAway) {
  Points points;
  for (int k = 0; k < 20; ++k) points.emplace_back(1e6 * (k - 10), 0, 1e7);
  Expect(FromPoints(points), false);
}

TEST_F(TrainerDegenerateTest, TwoViews) {
  views_.resize(2);
  Expect(Start(), true);
}

TEST_F(TrainerDegenerateTest, OneView) {
  views_.resize(1);
  Expect(Start(), true);
}

TEST_F(TrainerDegenerateTest, ViewsThatAreAllTheSame) {
  for (size_t k = 1; k < views_.size(); ++k) {
    views_[k].cam_from_world = views_[0].cam_from_world;
    photos_[k] = photos_[0];
    WritePhoto(k);
  }
  Expect(Start(), true);
}

TEST_F(TrainerDegenerateTest, ConstantPhotos) {
  for (const uint8_t value : {0, 128, 255}) {
    for (size_t k = 0; k < views_.size(); ++k) {
      std::fill_n(photos_[k].data(), photos_[k].size(), value);
      WritePhoto(k);
    }
    // On black nothing has to be left of black photos.
    Expect(Start(), value != 0);
  }
}

TEST_F(TrainerDegenerateTest, ExposureThatChangesBetweenViews) {
  for (size_t k = 0; k < views_.size(); ++k) {
    const double gain = k % 2 == 0 ? 0.3 : 2.5;
    for (size_t i = 0; i < photos_[k].size(); ++i) {
      photos_[k].data()[i] =
          static_cast<uint8_t>(std::min(255.0, gain * photos_[k].data()[i]));
    }
    WritePhoto(k);
  }
  Expect(Start(), true);
}

TEST_F(TrainerDegenerateTest, NoiseForPhotos) {
  for (size_t k = 0; k < views_.size(); ++k) {
    for (size_t i = 0; i < photos_[k].size(); ++i) {
      photos_[k].data()[i] = static_cast<uint8_t>(RandomBits(9, k, i));
    }
    WritePhoto(k);
  }
  Expect(Start(), true);
}

TEST_F(TrainerDegenerateTest, ABudgetOfOne) { Expect(Start(), true, 1); }

}  // namespace
}  // namespace freegs::splat
