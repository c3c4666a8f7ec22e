// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/instance_clustering.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "splat/render/renderer.h"
#include "tests/semantics/synthetic_gaussians.h"

namespace freegs::semantics {
namespace {

// The table scene, photographed by the renderer itself.
class InstanceClusteringTest : public testing::Test {
 protected:
  InstanceClusteringTest() {
    for (int i = 0; i < 6; ++i) {
      View view = LookAtOrigin(1.05 * i);
      view.camera = view.camera.Resized(160, 120);
      views_.push_back(view);
    }
    options_.method = ClusteringMethod::kUnion;
  }

  StatusOr<InstanceClusterer> Clusterer(
      int threads = 2, const CancellationToken* cancellation = nullptr) {
    ThreadPool pool(threads);
    const auto photo_of = [&](size_t v) -> StatusOr<ImageU8> {
      ++num_photos_;
      ThreadPool one_thread(1);
      const splat::RenderedView picture =
          splat::RenderView(scene_.model,
                            views_[v].camera,
                            views_[v].cam_from_world,
                            splat::RenderOptions(),
                            one_thread);
      ImageU8 photo(160, 120, 3);
      for (size_t i = 0; i < photo.size(); ++i) {
        photo.data()[i] = static_cast<uint8_t>(
            255 * std::clamp(picture.color.data()[i], 0.0f, 1.0f));
      }
      return photo;
    };
    return InstanceClusterer::Create(scene_.model,
                                     views_,
                                     {.views = views_,
                                      .photo_of = photo_of,
                                      .render = splat::RenderOptions()},
                                     options_,
                                     pool,
                                     cancellation);
  }

  StatusOr<InstanceLabels> Cluster(
      int threads = 2, const CancellationToken* cancellation = nullptr) {
    FREEGS_ASSIGN_OR_RETURN(InstanceClusterer clusterer,
                            Clusterer(threads, cancellation));
    ThreadPool pool(threads);
    return clusterer.Cluster({}, pool, cancellation);
  }

  SyntheticGaussians scene_ = MakeTableScene();
  std::vector<View> views_;
  InstanceClusteringOptions options_;
  std::atomic<int> num_photos_ = 0;
};

TEST_F(InstanceClusteringTest, LabelsAreNumberedBySizeForAnyNumberOfThreads) {
  for (const auto method :
       {ClusteringMethod::kEvidence, ClusteringMethod::kUnion}) {
    options_.method = method;
    const auto one = Cluster(1);
    const auto three = Cluster(3);
    ASSERT_TRUE(one.ok() && three.ok()) << one.status().message();
    EXPECT_EQ(one->labels, three->labels);
    EXPECT_EQ(one->scores, three->scores);
    ASSERT_GT(one->num_instances, 1);
    EXPECT_EQ(one->scores.size(), static_cast<size_t>(one->num_instances));
    EXPECT_EQ(one->is_plane.size(), one->scores.size());
    std::vector<size_t> size(one->num_instances, 0);
    for (const int32_t label : one->labels) {
      if (label >= 0) ++size[label];
    }
    EXPECT_TRUE(std::is_sorted(size.rbegin(), size.rend()));
    EXPECT_GT(size.back(), 0u);
    EXPECT_GT(one->num_clustered, 0u);
    EXPECT_LT(one->noise_after, 0.1);
  }
}

TEST_F(InstanceClusteringTest, TheTreeKnowsHazeBesideHaze) {
  options_.method = ClusteringMethod::kEvidence;
  const auto clear = Cluster();
  ASSERT_TRUE(clear.ok()) << clear.status().message();
  size_t last = 0;  // The labelled Gaussian of the largest x.
  for (size_t g = 0; g < clear->labels.size(); ++g) {
    if (clear->labels[g] < 0) continue;
    if (clear->labels[last] < 0 ||
        scene_.model.means[3 * g] > scene_.model.means[3 * last]) {
      last = g;
    }
  }
  const Eigen::Vector3d at(scene_.model.means[3 * last],
                           scene_.model.means[3 * last + 1],
                           scene_.model.means[3 * last + 2]);
  for (const double radii : {0.15, 0.3, 0.8}) {
    scene_.Add(at + radii * clear->scene_radius * Eigen::Vector3d::UnitX(),
               {0.5, 0.5, 0.5},
               0.001,
               0.05,
               -1);
  }
  const auto hazy = Cluster();
  ASSERT_TRUE(hazy.ok()) << hazy.status().message();
  const std::vector<int32_t>& parts = hazy->hierarchy->part_of_gaussian;
  const size_t first = clear->labels.size();
  for (const size_t g : {first, first + 1}) {
    EXPECT_EQ(parts[g], parts[last]);
    EXPECT_EQ(hazy->labels[g], hazy->labels[last]);
  }
  EXPECT_EQ(parts[first + 2], -1);
  EXPECT_EQ(hazy->labels[first + 2], -1);
  EXPECT_EQ(hazy->num_clustered, clear->num_clustered);
}

TEST_F(InstanceClusteringTest, PhotographsAreLookedAtOnce) {
  options_.method = ClusteringMethod::kEvidence;
  auto clusterer = Clusterer();
  ASSERT_TRUE(clusterer.ok());
  EXPECT_EQ(num_photos_, 6);
  ThreadPool pool(2);
  const auto plain = clusterer->Cluster({}, pool, nullptr);
  const std::vector<float> vectors(scene_.model.size() * 2, 1.0f);
  ASSERT_TRUE(clusterer->Cluster({vectors, 2}, pool, nullptr).ok());
  const auto again = clusterer->Cluster({}, pool, nullptr);
  ASSERT_TRUE(plain.ok() && again.ok());
  EXPECT_EQ(again->labels, plain->labels);
  EXPECT_EQ(num_photos_, 6);
}

TEST_F(InstanceClusteringTest, PairsThatAreOneThingAreJoined) {
  options_.method = ClusteringMethod::kEvidence;
  auto clusterer = Clusterer();
  ASSERT_TRUE(clusterer.ok()) << clusterer.status().message();
  ThreadPool pool(2);
  const auto apart = clusterer->Cluster({}, pool, nullptr);
  ASSERT_TRUE(apart.ok());
  const int count = apart->num_instances;
  ASSERT_GE(count, 4);
  // The second pair shares an instance with the first, which is surer.
  const JoinedInstances joined =
      clusterer->Join(*apart, {{{1, 2}, 0.8}, {{2, 3}, 0.9}});
  EXPECT_EQ(joined.labels.num_instances, count - 1);
  EXPECT_EQ(joined.made_of.size(),
            static_cast<size_t>(joined.labels.num_instances));
  for (size_t g = 0; g < apart->labels.size(); ++g) {
    const int32_t before = apart->labels[g];
    const int32_t label = joined.labels.labels[g];
    ASSERT_EQ(label < 0, before < 0);
    if (label < 0) continue;
    const bool is_part = before == 2 || before == 3;
    const InstancePair expected = {is_part ? 2 : before, is_part ? 3 : before};
    EXPECT_EQ(joined.made_of[label], expected);
  }
  // What other commands read gives the same instances.
  EXPECT_EQ(CutHierarchy(*joined.labels.hierarchy,
                         joined.labels.hierarchy->granularity)
                .label_of_gaussian,
            joined.labels.labels);
}

TEST_F(InstanceClusteringTest, EvidenceNeedsPhotographs) {
  options_.method = ClusteringMethod::kEvidence;
  ThreadPool pool(1);
  const auto clusterer = InstanceClusterer::Create(
      scene_.model, views_, {}, options_, pool, nullptr);
  EXPECT_EQ(clusterer.status().code(), StatusCode::kInvalidArgument);
  EXPECT_NE(clusterer.status().message().find("photographs"),
            std::string::npos);
}

TEST_F(InstanceClusteringTest, BrokenGaussiansTakeNoPart) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  scene_.Add({nan, 0, 0}, {0, 0, 0}, 0.1, 0.9, -1);
  scene_.Add({0, inf, 0}, {0, 0, 0}, 0.1, 0.9, -1);
  scene_.Add({1e20, 0, 0}, {0, 0, 0}, 0.1, 0.9, -1);
  scene_.Add({1e9, 1e9, 0}, {nan, 0, 0}, 0.1, 0.9, -1);
  const auto result = Cluster();
  ASSERT_TRUE(result.ok()) << result.status().message();
  for (size_t i = scene_.truth.size() - 4; i < scene_.truth.size(); ++i) {
    EXPECT_EQ(result->labels[i], -1);
  }
}

TEST_F(InstanceClusteringTest, EmptyAndTinyModels) {
  scene_ = SyntheticGaussians();
  for (int count = 0; count < 4; ++count) {
    for (const auto method :
         {ClusteringMethod::kEvidence, ClusteringMethod::kUnion}) {
      options_.method = method;
      const auto result = Cluster();
      ASSERT_TRUE(result.ok()) << result.status().message();
      EXPECT_EQ(result->labels.size(), static_cast<size_t>(count));
    }
    scene_.Add({0, 0, 0.1 * count}, {1, 0, 0}, 0.1, 0.5, 0);
  }
}

TEST_F(InstanceClusteringTest, StopsWhenCancelled) {
  CancellationToken cancellation;
  cancellation.Cancel();
  for (const auto method :
       {ClusteringMethod::kEvidence, ClusteringMethod::kUnion}) {
    options_.method = method;
    EXPECT_EQ(Cluster(1, &cancellation).status().code(),
              StatusCode::kInterrupted);
  }
}

TEST_F(InstanceClusteringTest, RefusesBadOptionsAndVectorsOfAnotherModel) {
  options_.union_space.hdbscan.min_samples = 0;
  EXPECT_FALSE(Clusterer().ok());
  options_ = InstanceClusteringOptions();
  options_.method = ClusteringMethod::kUnion;
  auto clusterer = Clusterer();
  ASSERT_TRUE(clusterer.ok());
  ThreadPool pool(1);
  const std::vector<float> vectors(7, 1.0f);
  EXPECT_EQ(clusterer->Cluster({vectors, 7}, pool, nullptr).status().code(),
            StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace freegs::semantics
