// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/evidence_clustering.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "splat/render/renderer.h"
#include "tests/semantics/synthetic_gaussians.h"

namespace freegs::semantics {
namespace {

// The table scene, photographed by the renderer itself.
class EvidenceClusteringTest : public testing::Test {
 protected:
  EvidenceClusteringTest() : scene_(MakeTableScene()) {
    for (int i = 0; i < 6; ++i) {
      View view = LookAtOrigin(1.05 * i);
      view.camera = view.camera.Resized(160, 120);
      views_.push_back(view);
    }
  }

  StatusOr<EvidenceClusters> Cluster(int threads, double granularity) {
    ThreadPool pool(threads);
    const PatchScene scene{
        .model = scene_.model,
        .views = views_,
        .render = render_,
        .photo_of = [&](size_t v) -> StatusOr<ImageU8> {
          ThreadPool one_thread(1);
          const splat::RenderedView picture =
              splat::RenderView(scene_.model,
                                views_[v].camera,
                                views_[v].cam_from_world,
                                render_,
                                one_thread);
          ImageU8 photo(160, 120, 3);
          for (size_t i = 0; i < photo.size(); ++i) {
            photo.data()[i] = static_cast<uint8_t>(
                255 * std::clamp(picture.color.data()[i], 0.0f, 1.0f));
          }
          return photo;
        },
        .scene_radius = 1};
    FREEGS_ASSIGN_OR_RETURN(const LearntModels models, DefaultModels());
    FREEGS_ASSIGN_OR_RETURN(const std::vector<ScenePatches> divisions,
                            BuildScenePatches(scene, pool, nullptr));
    return ClusterByEvidence(scene_.model,
                             divisions,
                             scene.scene_radius,
                             0.2,
                             models,
                             {.granularity = granularity},
                             pool);
  }

  const SyntheticGaussians scene_;
  const splat::RenderOptions render_;
  std::vector<View> views_;
};

size_t NumLabels(const std::vector<int32_t>& labels) {
  std::set<int32_t> distinct(labels.begin(), labels.end());
  distinct.erase(-1);
  return distinct.size();
}

TEST_F(EvidenceClusteringTest, SameBytesForAnyNumberOfThreads) {
  const auto one = Cluster(1, 0);
  const auto three = Cluster(3, 0);
  ASSERT_TRUE(one.ok() && three.ok());
  EXPECT_EQ(one->labels, three->labels);
  EXPECT_EQ(one->scores, three->scores);
  EXPECT_EQ(one->hierarchy.tree.merges, three->hierarchy.tree.merges);
  EXPECT_EQ(one->hierarchy.part_of_gaussian, three->hierarchy.part_of_gaussian);
}

TEST_F(EvidenceClusteringTest, GranularityMakesMoreInstances) {
  const auto coarse = Cluster(2, -100);
  const auto normal = Cluster(2, 0);
  const auto fine = Cluster(2, 100);
  ASSERT_TRUE(coarse.ok() && normal.ok() && fine.ok());
  EXPECT_LE(NumLabels(coarse->labels), NumLabels(normal->labels));
  EXPECT_LE(NumLabels(normal->labels), NumLabels(fine->labels));
  EXPECT_LT(NumLabels(coarse->labels), NumLabels(fine->labels));
  for (const double score : normal->scores) {
    EXPECT_GE(score, 0.0);
    EXPECT_LE(score, 1.0);
  }
}

TEST_F(EvidenceClusteringTest, TheHierarchyGivesTheSameInstances) {
  const auto clusters = Cluster(2, 0.5);
  ASSERT_TRUE(clusters.ok());
  EXPECT_EQ(CutHierarchy(clusters->hierarchy, 0.5).label_of_gaussian,
            clusters->labels);
  const auto coarse = Cluster(2, -1);
  ASSERT_TRUE(coarse.ok());
  EXPECT_EQ(CutHierarchy(clusters->hierarchy, -1).label_of_gaussian,
            coarse->labels);
}

TEST_F(EvidenceClusteringTest, RefusesAGranularityThatIsNoNumber) {
  EXPECT_EQ(Cluster(1, std::nan("")).status().code(),
            StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace freegs::semantics
