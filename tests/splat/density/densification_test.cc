// SPDX-License-Identifier: BSD-3-Clause
// Who is cloned, split and pruned, what stays as it was, and where children
// lie.

#include "splat/density/densification.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/splat/random_model.h"

namespace freegs::splat {
namespace {

constexpr double kExtent = 10;
constexpr uint64_t kSeed = 17;

float Logit(double p) { return static_cast<float>(std::log(p / (1 - p))); }

// Gaussians of opacity 0.5 and standard deviation `scale`, with Adam moments
// and no statistics.
struct Scene {
  GaussianModel model;
  Adam adam;
  DensificationStatistics statistics;

  Scene(size_t count, double scale) : model(RandomModel(count, 1, 3)) {
    std::fill(model.log_scales.begin(),
              model.log_scales.end(),
              static_cast<float>(std::log(scale)));
    std::fill(model.opacity_logits.begin(), model.opacity_logits.end(), 0.0f);
    adam.Reset(model);
    AdamState state = adam.state();
    state.steps = 5;
    state.first_moments = RandomModel(count, 1, 4);
    state.second_moments = RandomModel(count, 1, 5);
    adam.set_state(state);
    statistics.Reset(count);
  }

  void SetGradient(size_t index, float gradient) {
    statistics.gradient_sum[index] = 2 * gradient;
    statistics.visible_steps[index] = 2;
  }

  void Run(const DensificationOptions& options, int64_t iteration = 600) {
    Densify(options, kExtent, kSeed, iteration, &model, &adam, &statistics);
  }
};

// Gaussian `index` alone.
GaussianModel At(const GaussianModel& model, size_t index) {
  GaussianModel one;
  one.sh_degree = model.sh_degree;
  one.AppendFrom(model, index);
  return one;
}

GaussianModel Zeros(const GaussianModel& model) {
  GaussianModel zeros;
  zeros.sh_degree = model.sh_degree;
  zeros.Resize(1);
  return zeros;
}

TEST(DensificationStatisticsTest, SumsInUnitsOfTheImage) {
  ThreadPool pool(2);
  DensificationStatistics statistics;
  statistics.Reset(3);
  const std::vector<uint32_t> visible = {0, 2};
  statistics.AddView(
      visible, std::vector<float>{0.03f, 0.08f, 0.0f, -0.5f}, 200, 100, pool);
  EXPECT_FLOAT_EQ(statistics.gradient_sum[0], 5.0f);
  EXPECT_FLOAT_EQ(statistics.gradient_sum[2], 25.0f);
  statistics.AddView(
      std::vector<uint32_t>{2}, std::vector<float>{0.0f, 0.1f}, 200, 100, pool);
  EXPECT_FLOAT_EQ(statistics.MeanGradient(2), 15.0f);
  EXPECT_EQ(statistics.MeanGradient(1), 0.0f);
  EXPECT_EQ(statistics.visible_steps[2], 2u);
  statistics.Select(std::vector<uint32_t>{2});
  EXPECT_EQ(statistics.size(), 1u);
  EXPECT_FLOAT_EQ(statistics.MeanGradient(0), 15.0f);
}

TEST(DensificationStatisticsTest, KeepsTheLargestShareDominated) {
  const auto picture = [](int width, std::vector<int32_t> pixels) {
    Image<int32_t> dominant(width, static_cast<int>(pixels.size()) / width, 1);
    std::copy(pixels.begin(), pixels.end(), dominant.data());
    return dominant;
  };
  ThreadPool pool(2);
  DensificationStatistics statistics;
  statistics.Reset(4);
  statistics.AddDominant(picture(4, {0, 0, 2, -1, -1, 0, 2, -1}), pool);
  EXPECT_EQ(statistics.max_dominant_share,
            (std::vector<float>{3.0f / 8, 0, 2.0f / 8, 0}));
  // Counts do not add up over pictures, whose size may change.
  statistics.AddDominant(picture(2, {0, 2, 2, 3}), pool);
  EXPECT_EQ(statistics.max_dominant_share,
            (std::vector<float>{3.0f / 8, 0, 0.5f, 0.25f}));
  statistics.AddDominant(Image<int32_t>(), pool);
  statistics.Select(std::vector<uint32_t>{2, 3});
  EXPECT_EQ(statistics.max_dominant_share, (std::vector<float>{0.5f, 0.25f}));
  // 7 is unknown and left out.
  statistics.AddDominant(picture(2, {1, 1, -1, 7}), pool);
  EXPECT_EQ(statistics.max_dominant_share, (std::vector<float>{0.5f, 0.5f}));
  statistics.Reset(1);
  EXPECT_EQ(statistics.max_dominant_share, std::vector<float>{0});
}

// With more pixels and Gaussians than one thread takes at once.
TEST(DensificationStatisticsTest, AreTheSameForAnyNumberOfThreads) {
  constexpr uint32_t kGaussians = 30000;
  Image<int32_t> dominant(400, 200, 1);
  for (size_t k = 0; k < dominant.size(); ++k) {
    dominant.data()[k] =
        static_cast<int32_t>(RandomIndex(1, 2, k, kGaussians + 1)) - 1;
  }
  std::vector<uint32_t> visible;
  std::vector<float> gradients;
  for (uint32_t i = 0; i < kGaussians; i += 2) {
    visible.push_back(i);
    gradients.push_back(static_cast<float>(RandomUniform(3, 0, i)));
    gradients.push_back(static_cast<float>(RandomUniform(3, 1, i)));
  }
  std::vector<DensificationStatistics> all(2);
  for (const size_t k : {0, 1}) {
    ThreadPool pool(k == 0 ? 1 : 4);
    all[k].Reset(kGaussians);
    for (int step = 0; step < 2; ++step) {
      all[k].AddView(visible, gradients, 400, 200, pool);
      all[k].AddDominant(dominant, pool);
    }
  }
  EXPECT_EQ(all[0].gradient_sum, all[1].gradient_sum);
  EXPECT_EQ(all[0].visible_steps, all[1].visible_steps);
  EXPECT_EQ(all[0].max_dominant_share, all[1].max_dominant_share);
  std::vector<int> pixels(kGaussians, 0);
  for (size_t k = 0; k < dominant.size(); ++k) {
    if (dominant.data()[k] >= 0) ++pixels[dominant.data()[k]];
  }
  for (uint32_t i = 0; i < kGaussians; ++i) {
    EXPECT_FLOAT_EQ(all[1].max_dominant_share[i],
                    static_cast<float>(pixels[i]) / 80000);
  }
}

TEST(DensificationTest, SmallOnesAreCloned) {
  Scene scene(4, 0.05);
  scene.SetGradient(1, 3e-4f);
  scene.SetGradient(2, 1.9e-4f);
  const Scene before = scene;
  scene.Run({});
  ASSERT_EQ(scene.model.size(), 5u);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(SameParameters(At(scene.model, i), At(before.model, i)));
    EXPECT_TRUE(SameParameters(At(scene.adam.state().first_moments, i),
                               At(before.adam.state().first_moments, i)));
    EXPECT_TRUE(SameParameters(At(scene.adam.state().second_moments, i),
                               At(before.adam.state().second_moments, i)));
  }
  EXPECT_TRUE(SameParameters(At(scene.model, 4), At(before.model, 1)));
  EXPECT_TRUE(SameParameters(At(scene.adam.state().first_moments, 4),
                             Zeros(scene.model)));
  EXPECT_TRUE(SameParameters(At(scene.adam.state().second_moments, 4),
                             Zeros(scene.model)));
  EXPECT_EQ(scene.adam.state().steps, 5);
  EXPECT_EQ(scene.statistics.size(), 5u);
  EXPECT_EQ(scene.statistics.MeanGradient(1), 0.0f);
}

TEST(DensificationTest, LargeOnesAreSplit) {
  Scene scene(3, 0.5);
  scene.SetGradient(0, 1.0f);
  const Scene before = scene;
  scene.Run({});
  ASSERT_EQ(scene.model.size(), 4u);
  // The parent is gone; the others moved up with their moments.
  EXPECT_TRUE(SameParameters(At(scene.model, 0), At(before.model, 1)));
  EXPECT_TRUE(SameParameters(At(scene.adam.state().first_moments, 1),
                             At(before.adam.state().first_moments, 2)));
  for (const size_t child : {2u, 3u}) {
    EXPECT_NEAR(std::exp(scene.model.log_scales[3 * child]), 0.5 / 1.6, 1e-6);
    EXPECT_EQ(scene.model.rotations[4 * child], before.model.rotations[0]);
    EXPECT_EQ(scene.model.opacity_logits[child], 0.0f);
    EXPECT_EQ(scene.model.sh_rest[9 * child + 4], before.model.sh_rest[4]);
    EXPECT_NE(scene.model.means[3 * child], before.model.means[0]);
    EXPECT_TRUE(SameParameters(At(scene.adam.state().second_moments, child),
                               Zeros(scene.model)));
  }
  EXPECT_NE(scene.model.means[6], scene.model.means[9]);
}

// Children of one Gaussian over many iterations follow its distribution.
TEST(DensificationTest, ChildrenAreDrawnFromTheParent) {
  constexpr size_t kCount = 20000;
  Scene scene(kCount, 1.0);
  const Eigen::Quaterniond rotation =
      Eigen::Quaterniond(0.9, 0.3, -0.4, 0.2).normalized();
  const Eigen::Vector3d mean(1, 2, 3);
  const Eigen::Vector3d deviations(0.2, 0.6, 1.5);
  for (size_t i = 0; i < kCount; ++i) {
    scene.SetGradient(i, 1.0f);
    for (int k = 0; k < 3; ++k) {
      scene.model.means[3 * i + k] = static_cast<float>(mean[k]);
      scene.model.log_scales[3 * i + k] =
          static_cast<float>(std::log(deviations[k]));
    }
    // Any length must do.
    scene.model.rotations[4 * i] = static_cast<float>(3 * rotation.w());
    scene.model.rotations[4 * i + 1] = static_cast<float>(3 * rotation.x());
    scene.model.rotations[4 * i + 2] = static_cast<float>(3 * rotation.y());
    scene.model.rotations[4 * i + 3] = static_cast<float>(3 * rotation.z());
  }
  scene.Run({});
  ASSERT_EQ(scene.model.size(), 2 * kCount);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < 2 * kCount; ++i) {
    const Eigen::Vector3d offset =
        Eigen::Vector3f(&scene.model.means[3 * i]).cast<double>() - mean;
    sum += offset;
    squares += offset * offset.transpose();
  }
  const Eigen::Matrix3d r = rotation.toRotationMatrix();
  const Eigen::Matrix3d expected =
      r * deviations.cwiseAbs2().asDiagonal() * r.transpose();
  EXPECT_LT((sum / (2 * kCount)).norm(), 0.03);
  EXPECT_LT((squares / (2 * kCount) - expected).norm(), 0.08);
}

TEST(DensificationTest, PrunesWhatIsTransparentOrNoNumber) {
  Scene scene(5, 0.05);
  scene.model.opacity_logits[0] = Logit(0.004);
  scene.SetGradient(0, 1.0f);  // Transparent: not cloned either.
  scene.model.opacity_logits[1] = Logit(0.006);
  scene.model.opacity_logits[2] = NAN;
  scene.model.log_scales[3 * 3] = NAN;
  const GaussianModel before = scene.model;
  scene.Run({});
  ASSERT_EQ(scene.model.size(), 2u);
  EXPECT_TRUE(SameParameters(At(scene.model, 0), At(before, 1)));
  EXPECT_TRUE(SameParameters(At(scene.model, 1), At(before, 4)));
}

TEST(DensificationTest, CapTakesTheLargestGradients) {
  Scene scene(10, 0.05);
  for (size_t i = 0; i < 10; ++i) {
    scene.SetGradient(i, 1e-3f * static_cast<float>((i * 7) % 10 + 1));
  }
  scene.model.opacity_logits[0] = Logit(0.001);  // Makes room for one.
  const GaussianModel before = scene.model;
  DensificationOptions options;
  options.max_gaussians = 12;
  scene.Run(options);
  ASSERT_EQ(scene.model.size(), 12u);
  // (i * 7) % 10 is 9, 8, 7 for i = 7, 4, 1.
  EXPECT_TRUE(SameParameters(At(scene.model, 9), At(before, 1)));
  EXPECT_TRUE(SameParameters(At(scene.model, 10), At(before, 4)));
  EXPECT_TRUE(SameParameters(At(scene.model, 11), At(before, 7)));

  // Already more than allowed: nothing is added, nothing else removed.
  options.max_gaussians = 5;
  for (size_t i = 0; i < 12; ++i) scene.SetGradient(i, 1.0f);
  scene.Run(options);
  EXPECT_EQ(scene.model.size(), 12u);
}

TEST(DensificationTest, BlurredOnesAreSplitWithoutGradient) {
  Scene scene(5, 0.05);  // Small: a gradient would clone them.
  scene.SetGradient(1, 1.0f);
  scene.SetGradient(2, 1.0f);
  scene.statistics.max_dominant_share = {3e-4f, 0, 3e-4f, 1.0f / 5000, 1e-4f};
  const Scene before = scene;
  Scene off = scene;
  off.Run({});
  ASSERT_EQ(off.model.size(), 7u);
  EXPECT_EQ(off.model.log_scales,
            std::vector<float>(3 * 7, before.model.log_scales[0]));

  // 0 and 2 are split: the share of 3 is not above the limit. 1 is cloned.
  scene.Run({.blur_split_share = 1.0 / 5000});
  ASSERT_EQ(scene.model.size(), 8u);
  EXPECT_TRUE(SameParameters(At(scene.model, 0), At(before.model, 1)));
  EXPECT_TRUE(SameParameters(At(scene.model, 3), At(before.model, 1)));
  for (const size_t child : {4u, 5u, 6u, 7u}) {
    EXPECT_NEAR(std::exp(scene.model.log_scales[3 * child]), 0.05 / 1.6, 1e-6);
  }
  EXPECT_EQ(scene.statistics.max_dominant_share, std::vector<float>(8, 0.0f));
}

TEST(DensificationTest, BlurSplitsGoFirstUnderACap) {
  Scene scene(6, 0.5);
  for (size_t i = 0; i < 4; ++i) scene.SetGradient(i, 1.0f);
  scene.statistics.max_dominant_share = {0, 0.1f, 0, 0, 0.2f, 0.3f};
  scene.model.opacity_logits[5] = Logit(0.001);  // Pruned, however blurred.
  Scene tight = scene;
  const GaussianModel before = scene.model;
  DensificationOptions options{.blur_split_share = 0.01, .max_gaussians = 8};
  scene.Run(options);
  ASSERT_EQ(scene.model.size(), 8u);
  // 1 and 4 are gone, and of the equal gradients the first.
  EXPECT_TRUE(SameParameters(At(scene.model, 0), At(before, 2)));
  EXPECT_TRUE(SameParameters(At(scene.model, 1), At(before, 3)));

  options.max_gaussians = 6;
  tight.Run(options);
  ASSERT_EQ(tight.model.size(), 6u);
  // The largest share alone.
  EXPECT_TRUE(SameParameters(At(tight.model, 1), At(before, 1)));
  EXPECT_TRUE(SameParameters(At(tight.model, 3), At(before, 3)));
}

TEST(DensificationTest, RepeatsExactlyAndVariesWithIterationAndSeed) {
  const auto run = [](uint64_t seed, int64_t iteration) {
    Scene scene(20, 0.5);
    for (size_t i = 0; i < 20; i += 3) scene.SetGradient(i, 1.0f);
    Densify({},
            kExtent,
            seed,
            iteration,
            &scene.model,
            &scene.adam,
            &scene.statistics);
    return scene.model;
  };
  EXPECT_TRUE(SameParameters(run(1, 600), run(1, 600)));
  EXPECT_FALSE(SameParameters(run(1, 600), run(1, 700)));
  EXPECT_FALSE(SameParameters(run(1, 600), run(2, 600)));
}

TEST(DensificationTest, EmptyModel) {
  Scene scene(0, 1.0);
  scene.Run({});
  EXPECT_TRUE(scene.model.empty());
}

TEST(DensificationTest, OptionsAreChecked) {
  EXPECT_TRUE(DensificationOptions().Check().ok());
  EXPECT_FALSE(DensificationOptions{.split_shrink = 0.5}.Check().ok());
  EXPECT_FALSE(DensificationOptions{.min_opacity = 1}.Check().ok());
  EXPECT_FALSE(DensificationOptions{.max_gaussians = -1}.Check().ok());
  EXPECT_FALSE(DensificationOptions{.blur_split_share = -0.1}.Check().ok());
  EXPECT_FALSE(DensificationOptions{.blur_split_share = NAN}.Check().ok());
}

}  // namespace
}  // namespace freegs::splat
