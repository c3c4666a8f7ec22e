// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/feature_lifting.h"

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/splat/dense_weights.h"
#include "tests/splat/test_scene.h"

namespace freegs::semantics {
namespace {

using splat::GaussianModel;
using splat::RandomSceneModel;
using splat::TestCamera;
using splat::TestPose;

std::vector<View> TestViews() {
  std::vector<View> views(3);
  for (int v = 0; v < 3; ++v) {
    views[v].name = "view" + std::to_string(v) + ".jpg";
    views[v].camera = TestCamera(60 + v, 50);
    views[v].cam_from_world = TestPose();
    views[v].cam_from_world.translation[0] += 0.3 * v;
  }
  return views;
}

ViewWeightsStore StoreOf(const GaussianModel& model,
                         const std::vector<View>& views,
                         const ViewWeightsOptions& options = {}) {
  return *ViewWeightsStore::Create(
      model, views, splat::RenderOptions(), options);
}

ImageF RandomFeatures(const Pinhole& camera, int channels, uint64_t seed) {
  ImageF features(camera.width, camera.height, channels);
  for (size_t k = 0; k < features.size(); ++k) {
    features.data()[k] = static_cast<float>(RandomNormal(seed, 1, k));
  }
  return features;
}

TEST(FeatureLifting, ConstantFeaturesStayConstant) {
  GaussianModel model = RandomSceneModel(300, 0, 5);
  model.means[2] = -50;  // Behind every camera.
  ViewWeightsStore store = StoreOf(model, TestViews());
  ThreadPool pool(2);
  const StatusOr<LiftedFeatures> lifted = LiftFeatures(
      store,
      [&](size_t view) -> StatusOr<ImageF> {
        const Pinhole& camera = store.camera(view);
        ImageF features(camera.width, camera.height, 3);
        for (size_t p = 0; p < features.num_pixels(); ++p) {
          features.data()[3 * p] = 1;
          features.data()[3 * p + 1] = -0.3f;
        }
        return features;
      },
      pool);
  ASSERT_TRUE(lifted.ok()) << lifted.status().message();
  EXPECT_EQ(lifted.value().channels, 3);
  size_t unseen = 0;
  for (size_t i = 0; i < model.size(); ++i) {
    const float* feature = &lifted.value().features[3 * i];
    const bool seen = lifted.value().seen(i);
    unseen += !seen;
    EXPECT_NEAR(feature[0], seen ? 1.0 : 0.0, 1e-5);
    EXPECT_NEAR(feature[1], seen ? -0.3 : 0.0, 1e-5);
    EXPECT_EQ(feature[2], 0);
  }
  EXPECT_FALSE(lifted.value().seen(0));
  EXPECT_EQ(lifted.value().num_unseen, unseen);
  EXPECT_GT(unseen, 0u);
  EXPECT_LT(unseen, model.size() / 2);
}

// Two Gaussians of opacity a = 0.5 and b = 0.8 on a line between two cameras of
// one pixel that look at each other: the first sees weights a and (1 - a) b,
// the second b and (1 - b) a. It sees red, the second green.
TEST(FeatureLifting, OfTwoGaussiansByHand) {
  GaussianModel model;
  model.Resize(2);
  for (int i = 0; i < 2; ++i) {
    model.means[3 * i + 2] = 2.0f + static_cast<float>(i);
    for (int k = 0; k < 3; ++k) {
      model.log_scales[3 * i + k] = std::log(0.1f);
    }
    model.rotations[4 * i] = 1;
  }
  model.opacity_logits = {0.0f, std::log(4.0f)};
  std::vector<View> views(2);
  for (View& view : views) view.camera = {1, 1, 10, 10, 0.5, 0.5};
  views[1].cam_from_world.rotation =
      Eigen::Quaterniond(0, 0, 1, 0);  // Half a turn about the vertical.
  views[1].cam_from_world.translation = Eigen::Vector3d(0, 0, 5);

  ViewWeightsStore store = StoreOf(model, views);
  ThreadPool pool(1);
  const StatusOr<LiftedFeatures> lifted = LiftFeatures(
      store,
      [](size_t view) -> StatusOr<ImageF> {
        ImageF features(1, 1, 2);
        features(0, 0, static_cast<int>(view)) = 1;
        return features;
      },
      pool);
  ASSERT_TRUE(lifted.ok()) << lifted.status().message();
  const std::vector<float>& f = lifted.value().features;
  EXPECT_NEAR(f[0], 0.5 / 0.6, 1e-5);
  EXPECT_NEAR(f[1], 0.1 / 0.6, 1e-5);
  EXPECT_NEAR(f[2], 0.4 / 1.2, 1e-5);
  EXPECT_NEAR(f[3], 0.8 / 1.2, 1e-5);
  EXPECT_NEAR(lifted.value().weights[0], 0.6, 1e-5);
  EXPECT_NEAR(lifted.value().weights[1], 1.2, 1e-5);
  EXPECT_EQ(lifted.value().num_unseen, 0u);
}

TEST(FeatureLifting, AgreesWithTheFormulaInDouble) {
  constexpr int kChannels = 37;
  const GaussianModel model = RandomSceneModel(80, 0, 9);
  const std::vector<View> views = TestViews();
  ViewWeightsStore store = StoreOf(model, views);
  ThreadPool pool(2);
  std::vector<double> sums(model.size() * kChannels, 0.0);
  std::vector<double> weights(model.size(), 0.0);
  for (size_t v = 0; v < views.size(); ++v) {
    const splat::RenderedView dense = splat::RenderDenseWeights(
        model, views[v].camera, views[v].cam_from_world, pool);
    const ImageF features = RandomFeatures(views[v].camera, kChannels, v);
    for (size_t p = 0; p < features.num_pixels(); ++p) {
      for (size_t i = 0; i < model.size(); ++i) {
        const double w = dense.features.data()[p * model.size() + i];
        weights[i] += w;
        for (int c = 0; c < kChannels; ++c) {
          sums[i * kChannels + c] += w * features.data()[p * kChannels + c];
        }
      }
    }
  }
  const StatusOr<LiftedFeatures> lifted = LiftFeatures(
      store,
      [&](size_t view) -> StatusOr<ImageF> {
        return RandomFeatures(store.camera(view), kChannels, view);
      },
      pool);
  ASSERT_TRUE(lifted.ok()) << lifted.status().message();
  for (size_t i = 0; i < model.size(); ++i) {
    EXPECT_NEAR(lifted.value().weights[i], weights[i], 1e-5 * weights[i]);
    for (int c = 0; c < kChannels && weights[i] > 0; ++c) {
      EXPECT_NEAR(lifted.value().features[i * kChannels + c],
                  sums[i * kChannels + c] / weights[i],
                  1e-5);
    }
  }
}

TEST(FeatureLifting, SameBytesForAnyNumberOfThreadsAndAnyStore) {
  const GaussianModel model = RandomSceneModel(500, 0, 6);
  std::vector<float> expected;
  for (const int threads : {1, 2, 5}) {
    ViewWeightsOptions options;
    if (threads == 5) options.max_memory_bytes = 0;
    ViewWeightsStore store = StoreOf(model, TestViews(), options);
    ThreadPool pool(threads);
    const StatusOr<LiftedFeatures> lifted = LiftFeatures(
        store,
        [&](size_t view) -> StatusOr<ImageF> {
          return RandomFeatures(store.camera(view), 70, view);
        },
        pool);
    ASSERT_TRUE(lifted.ok());
    if (expected.empty()) expected = lifted.value().features;
    EXPECT_EQ(lifted.value().features, expected);
  }
}

TEST(FeatureLifting, NamesTheViewWhoseFeaturesAreWrong) {
  const GaussianModel model = RandomSceneModel(20, 0, 2);
  ViewWeightsStore store = StoreOf(model, TestViews());
  ThreadPool pool(1);
  // View 1 has features of the given shape and value.
  const auto lift = [&](int width, int channels, float value) {
    return LiftFeatures(
               store,
               [&](size_t view) -> StatusOr<ImageF> {
                 const Pinhole& camera = store.camera(view);
                 if (view != 1) return ImageF(camera.width, camera.height, 4);
                 return ImageF(width, camera.height, channels, value);
               },
               pool)
        .status();
  };
  const int width = store.camera(1).width;
  EXPECT_TRUE(lift(width, 4, 0.5f).ok());
  for (const Status& status :
       {lift(width - 1, 4, 0.5f),
        lift(width, 3, 0.5f),
        lift(width, 0, 0.5f),
        lift(width, 4, std::numeric_limits<float>::quiet_NaN()),
        lift(width, 4, std::numeric_limits<float>::infinity())}) {
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    EXPECT_NE(status.message().find("view1.jpg"), std::string::npos)
        << status.message();
  }

  const auto fail = [](size_t) -> StatusOr<ImageF> {
    return InterruptedError("stopped");
  };
  EXPECT_EQ(LiftFeatures(store, fail, pool).status().code(),
            StatusCode::kInterrupted);
  ViewWeightsStore no_views = StoreOf(model, {});
  EXPECT_EQ(LiftFeatures(no_views, fail, pool).status().code(),
            StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace freegs::semantics
