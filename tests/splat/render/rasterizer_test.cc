// SPDX-License-Identifier: BSD-3-Clause

#include "splat/render/rasterizer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include <gtest/gtest.h>

#include "core/random.h"
#include "splat/render/renderer.h"
#include "tests/for_each_target.h"
#include "tests/splat/reference_renderer.h"
#include "tests/splat/test_scene.h"

namespace freegs::splat {
namespace {

constexpr int kFeatures = 3;

std::vector<float> RandomFeatures(size_t count) {
  std::vector<float> features(count * kFeatures);
  RandomStream random(11, 5);
  for (float& v : features) v = static_cast<float>(random.Normal());
  return features;
}

RenderOptions TestOptions() {
  RenderOptions options;
  options.background = {0.2f, 0.5f, 0.9f};
  return options;
}

// The parameter is GaussianModel::antialiased.
class RasterizerReference : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Antialiased, RasterizerReference, ::testing::Bool());

TEST_P(RasterizerReference, ForwardMatches) {
  GaussianModel model = RandomSceneModel(200, 3, 1);
  model.antialiased = GetParam();
  const std::vector<float> features = RandomFeatures(model.size());
  const Pinhole camera = TestCamera(75, 53);  // Partial tiles on both sides.
  ReferenceModel reference(model);
  reference.num_features = kFeatures;
  reference.features.assign(features.begin(), features.end());
  const std::vector<double> expected =
      ReferenceRender(reference, camera, TestPose(), TestOptions());

  ThreadPool pool(2);
  Rasterizer rasterizer;
  RasterImages images;
  rasterizer.Forward(model,
                     camera,
                     TestPose(),
                     TestOptions(),
                     {.depth = true, .features = {features, kFeatures}},
                     pool,
                     &images);
  size_t covered = 0;
  for (size_t p = 0; p < images.color.num_pixels(); ++p) {
    const double* want = &expected[p * (5 + kFeatures)];
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(images.color.data()[3 * p + c], want[c], 2e-4);
    }
    EXPECT_NEAR(images.transmittance.data()[p], want[3], 2e-4);
    for (int e = 0; e < 1 + kFeatures; ++e) {
      EXPECT_NEAR(
          images.extras.data()[p * (1 + kFeatures) + e], want[4 + e], 1e-3);
    }
    covered += want[3] < 0.5;
  }
  EXPECT_GT(covered, images.color.num_pixels() / 2);
}

// L = <random image, rendered image>, whose derivative with respect to every
// parameter is compared with central differences of the reference in double.
TEST_P(RasterizerReference, BackwardMatchesCentralDifferences) {
  GaussianModel model = RandomSceneModel(28, 3, 2);
  model.antialiased = GetParam();
  const std::vector<float> features = RandomFeatures(model.size());
  const Pinhole camera = TestCamera(37, 26);
  const int channels = 5 + kFeatures;
  std::vector<double> weights(static_cast<size_t>(camera.width) *
                              camera.height * channels);
  RandomStream random(5, 2);
  // Smooth weights: neighbouring pixels' contributions must not cancel into
  // rounding noise.
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      for (int c = 0; c < channels; ++c) {
        weights[(static_cast<size_t>(y) * camera.width + x) * channels + c] =
            std::sin(0.11 * x + 0.07 * y + c) + 0.1 * random.Normal();
      }
    }
  }

  ThreadPool pool(2);
  Rasterizer rasterizer;
  RasterImages images;
  rasterizer.Forward(model,
                     camera,
                     TestPose(),
                     TestOptions(),
                     {.depth = true, .features = {features, kFeatures}},
                     pool,
                     &images);
  ImageF d_color(camera.width, camera.height, 3);
  ImageF d_transmittance(camera.width, camera.height, 1);
  ImageF d_extras(camera.width, camera.height, 1 + kFeatures);
  for (size_t p = 0; p < d_color.num_pixels(); ++p) {
    const double* w = &weights[p * channels];
    for (int c = 0; c < 3; ++c) {
      d_color.data()[3 * p + c] = static_cast<float>(w[c]);
    }
    d_transmittance.data()[p] = static_cast<float>(w[3]);
    for (int e = 0; e < 1 + kFeatures; ++e) {
      d_extras.data()[p * (1 + kFeatures) + e] = static_cast<float>(w[4 + e]);
    }
  }
  GaussianModel gradients;
  gradients.sh_degree = model.sh_degree;
  gradients.Resize(model.size());
  std::vector<float> feature_gradients(features.size(), 0.0f);
  rasterizer.Backward(model,
                      {&d_color, &d_transmittance, &d_extras},
                      images,
                      pool,
                      &gradients,
                      feature_gradients);

  ReferenceModel reference(model);
  reference.num_features = kFeatures;
  reference.features.assign(features.begin(), features.end());
  const auto loss = [&] {
    const std::vector<double> image =
        ReferenceRender(reference, camera, TestPose(), TestOptions());
    double sum = 0;
    for (size_t i = 0; i < image.size(); ++i) sum += weights[i] * image[i];
    return sum;
  };
  const auto check = [&](const char* name,
                         std::vector<double>& parameters,
                         const std::vector<float>& gradient) {
    double largest = 0;
    for (const float g : gradient) {
      largest = std::max(largest, std::abs(static_cast<double>(g)));
    }
    ASSERT_GT(largest, 0) << name;
    int bad = 0;
    for (size_t i = 0; i < parameters.size(); ++i) {
      const double value = parameters[i];
      const double step = 1e-6;
      parameters[i] = value + step;
      const double plus = loss();
      parameters[i] = value - step;
      const double minus = loss();
      parameters[i] = value;
      const double expected = (plus - minus) / (2 * step);
      const double tolerance = 1e-3 * std::abs(expected) + 2e-4 * largest;
      if (std::abs(gradient[i] - expected) > tolerance) {
        // A pixel crossing alpha = 1/255 within the step jumps; rare, and not
        // a property of the derivative.
        ++bad;
        ADD_FAILURE() << name << '[' << i << "]: " << gradient[i]
                      << " expected " << expected;
        if (bad > 5) return;
      }
    }
  };
  check("means", reference.means, gradients.means);
  check("log_scales", reference.log_scales, gradients.log_scales);
  check("rotations", reference.rotations, gradients.rotations);
  check("opacity_logits", reference.opacity_logits, gradients.opacity_logits);
  check("sh_dc", reference.sh_dc, gradients.sh_dc);
  check("sh_rest", reference.sh_rest, gradients.sh_rest);
  check("features", reference.features, feature_gradients);
}

TEST(Rasterizer, SameBytesForAnyNumberOfThreads) {
  const GaussianModel model = RandomSceneModel(3000, 2, 3);
  const Pinhole camera = TestCamera(203, 131);
  ImageF d_color(camera.width, camera.height, 3);
  RandomStream random(9, 9);
  for (size_t i = 0; i < d_color.size(); ++i) {
    d_color.data()[i] = static_cast<float>(random.Normal());
  }
  std::vector<float> first_image, first_means, first_rest;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    Rasterizer rasterizer;
    RasterImages images;
    rasterizer.Forward(model,
                       camera,
                       TestPose(),
                       TestOptions(),
                       {.depth = true},
                       pool,
                       &images);
    GaussianModel gradients;
    gradients.sh_degree = model.sh_degree;
    gradients.Resize(model.size());
    rasterizer.Backward(model, {.color = &d_color}, images, pool, &gradients);
    const std::vector<float> image(images.color.data(),
                                   images.color.data() + images.color.size());
    if (first_image.empty()) {
      first_image = image;
      first_means = gradients.means;
      first_rest = gradients.sh_rest;
    }
    // Bytes, not values: memcmp also tells -0 from 0.
    EXPECT_EQ(
        0,
        std::memcmp(
            image.data(), first_image.data(), image.size() * sizeof(float)));
    EXPECT_EQ(0,
              std::memcmp(gradients.means.data(),
                          first_means.data(),
                          first_means.size() * sizeof(float)));
    EXPECT_EQ(0,
              std::memcmp(gradients.sh_rest.data(),
                          first_rest.data(),
                          first_rest.size() * sizeof(float)));
  }
}

TEST(Rasterizer, LabelsAreTheArgmaxOfRenderedOneHotVectors) {
  const GaussianModel model = RandomSceneModel(300, 0, 4);
  constexpr int kLabels = 7;
  std::vector<int32_t> labels(model.size());
  std::vector<float> one_hot(model.size() * kLabels, 0.0f);
  for (size_t i = 0; i < model.size(); ++i) {
    labels[i] = static_cast<int32_t>(RandomIndex(1, 2, i, kLabels + 1)) - 1;
    if (labels[i] >= 0) one_hot[i * kLabels + labels[i]] = 1;
  }
  const Pinhole camera = TestCamera(90, 70);
  ThreadPool pool(2);
  const Image<int32_t> result = RenderLabels(
      model, camera, TestPose(), TestOptions(), pool, labels, 0.3f);
  const RenderedView view = RenderView(
      model, camera, TestPose(), TestOptions(), pool, {one_hot, kLabels});
  int differing = 0, labelled = 0;
  for (size_t p = 0; p < view.features.num_pixels(); ++p) {
    const float* votes = view.features.data() + p * kLabels;
    int32_t best = 0;
    float sum = 0;
    for (int l = 0; l < kLabels; ++l) {
      sum += votes[l];
      if (votes[l] > votes[best]) best = l;
    }
    if (sum < 0.3f) best = -1;
    labelled += best >= 0;
    differing += result.data()[p] != best;
  }
  EXPECT_GT(labelled, 1000);
  // Sums in another order may flip a tie.
  EXPECT_LE(differing, 2);
}

TEST(Rasterizer, EmptyAndInvisibleModelsGiveTheBackground) {
  ThreadPool pool(2);
  const Pinhole camera = TestCamera(40, 30);
  GaussianModel behind = RandomSceneModel(50, 1, 6);
  for (size_t i = 0; i < behind.size(); ++i) behind.means[3 * i + 2] = -10;
  for (const GaussianModel& model : {GaussianModel(), behind}) {
    const RenderedView view =
        RenderView(model, camera, TestPose(), TestOptions(), pool);
    for (size_t p = 0; p < view.color.num_pixels(); ++p) {
      EXPECT_EQ(view.color.data()[3 * p + 2], 0.9f);
      EXPECT_EQ(view.transmittance.data()[p], 1.0f);
      EXPECT_EQ(view.depth.data()[p], 0.0f);
    }
  }
}

// NaN, infinities, coincident cameras and enormous splats must neither crash
// nor poison the picture.
TEST(Rasterizer, DegenerateGaussiansLeaveFinitePictures) {
  GaussianModel model = RandomSceneModel(60, 3, 8);
  const Rigid3d pose = TestPose();
  const Eigen::Vector3f centre = CameraCentre(pose).cast<float>();
  for (size_t i = 0; i < model.size(); ++i) {
    switch (i % 6) {
      case 0:
        for (int k = 0; k < 3; ++k) model.means[3 * i + k] = centre[k];
        break;
      case 1:
        model.log_scales[3 * i] = 60;
        break;
      case 2:
        model.opacity_logits[i] = NAN;
        break;
      case 3:
        model.rotations[4 * i] = INFINITY;
        break;
      case 4:
        for (int k = 0; k < 3; ++k) model.log_scales[3 * i + k] = -90;
        break;
      default:
        break;
    }
  }
  ThreadPool pool(2);
  const RenderedView view =
      RenderView(model, TestCamera(64, 48), pose, TestOptions(), pool);
  for (size_t i = 0; i < view.color.size(); ++i) {
    EXPECT_TRUE(std::isfinite(view.color.data()[i]));
  }
}

// Numbers of Gaussians that fill no whole group of lanes, and every SH degree.
TEST(Rasterizer, EveryInstructionSetAgrees) {
  const Pinhole camera = TestCamera(52, 37);
  ThreadPool pool(2);
  const ImageF d_color(camera.width, camera.height, 3, 1.0f);
  for (int degree = 0; degree <= kMaxShDegree; ++degree) {
    const GaussianModel model = RandomSceneModel(61 + degree, degree, 31);
    ImageF best_color;
    GaussianModel best;
    ForEachTarget([&] {
      Rasterizer rasterizer;
      RasterImages images;
      rasterizer.Forward(
          model, camera, TestPose(), TestOptions(), {}, pool, &images);
      GaussianModel gradients;
      gradients.sh_degree = degree;
      gradients.Resize(model.size());
      rasterizer.Backward(model, {.color = &d_color}, images, pool, &gradients);
      if (best.empty()) {
        best_color = images.color;
        best = gradients;
      }
      for (size_t k = 0; k < best_color.size(); ++k) {
        ASSERT_NEAR(images.color.data()[k], best_color.data()[k], 1e-4) << k;
      }
      for (const Parameter parameter : kAllParameters) {
        const auto& got = ParameterArray(gradients, parameter);
        const auto& want = ParameterArray(best, parameter);
        double largest = 0;
        for (const float v : want)
          largest = std::max<double>(largest, std::abs(v));
        ASSERT_TRUE(want.empty() || largest > 0);
        for (size_t k = 0; k < want.size(); ++k) {
          ASSERT_NEAR(
              got[k], want[k], 1e-3 * std::abs(want[k]) + 1e-4 * largest)
              << "degree " << degree << ", parameter "
              << static_cast<int>(parameter) << ", " << k;
        }
      }
    });
  }
}

TEST(Rasterizer, ContributionsAgreeWithTheRenderedPicture) {
  const GaussianModel model = RandomSceneModel(200, 1, 21);
  const Pinhole camera = TestCamera(75, 50);
  ThreadPool pool(2);
  Rasterizer rasterizer;
  ViewContributions contributions;
  rasterizer.Contributions(
      model, camera, TestPose(), TestOptions(), nullptr, pool, &contributions);
  RasterImages images;
  rasterizer.Forward(model,
                     camera,
                     TestPose(),
                     TestOptions(),
                     {.dominant = true},
                     pool,
                     &images);

  ASSERT_EQ(contributions.model_index, rasterizer.projection().visible);
  // Forward may stop at opaque tiles: both only see what is not behind them.
  double opacity = 0;
  size_t dominated = 0;
  for (size_t p = 0; p < images.transmittance.size(); ++p) {
    EXPECT_EQ(images.dominant.data()[p], contributions.dominant.data()[p]);
    EXPECT_EQ(images.transmittance.data()[p],
              contributions.transmittance.data()[p]);
    opacity += 1.0 - images.transmittance.data()[p];
    if (images.dominant.data()[p] >= 0) ++dominated;
  }
  double weights = 0;
  size_t dominant = 0;
  for (size_t s = 0; s < contributions.model_index.size(); ++s) {
    weights += contributions.weight_sum[s];
    dominant += contributions.num_dominant[s];
    EXPECT_LE(contributions.num_dominant[s], contributions.num_pixels[s]);
    EXPECT_LE(contributions.weight_sum[s],
              static_cast<float>(contributions.num_pixels[s]));
  }
  EXPECT_NEAR(weights, opacity, 1e-4 * opacity);
  EXPECT_EQ(dominant, dominated);
  EXPECT_GT(dominated, images.dominant.size() / 2);

  // Without the right part of the picture.
  ImageU8 mask(75, 50, 1, 255);
  double left_opacity = 0;
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 75; ++x) {
      if (x < 41) left_opacity += 1.0 - images.transmittance(x, y);
      if (x >= 41) mask(x, y) = 0;
    }
  }
  rasterizer.Contributions(
      model, camera, TestPose(), TestOptions(), &mask, pool, &contributions);
  EXPECT_NEAR(std::accumulate(contributions.weight_sum.begin(),
                              contributions.weight_sum.end(),
                              0.0),
              left_opacity,
              1e-4 * left_opacity);
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 75; ++x) {
      EXPECT_EQ(contributions.dominant(x, y),
                x < 41 ? images.dominant(x, y) : -1);
    }
  }
}

TEST(Rasterizer, TheDominantGaussianHasTheLargestWeight) {
  // One behind the other on the optical axis: the nearer is nearly
  // transparent, so the farther one has the larger weight where both are.
  GaussianModel model = RandomSceneModel(2, 0, 3);
  const Pinhole camera = TestCamera(40, 30);
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 3; ++k) {
      model.means[3 * i + k] = k == 2 ? 2.0f + static_cast<float>(i) : 0.0f;
      model.log_scales[3 * i + k] = std::log(0.3f);
    }
    model.opacity_logits[i] = i == 0 ? -2.0f : 3.0f;
  }
  ThreadPool pool(1);
  Rasterizer rasterizer;
  RasterImages images;
  rasterizer.Forward(model,
                     camera,
                     Rigid3d(),
                     TestOptions(),
                     {.dominant = true},
                     pool,
                     &images);
  EXPECT_EQ(
      images.dominant(static_cast<int>(camera.cx), static_cast<int>(camera.cy)),
      1);
  EXPECT_EQ(images.dominant(0, 0), -1);
}

}  // namespace
}  // namespace freegs::splat
