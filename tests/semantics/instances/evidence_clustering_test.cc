// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/evidence_clustering.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>
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

// A hierarchy whose instances are its leaves, each of which has the Gaussians
// with its number.
Hierarchy FromParts(std::vector<int32_t> part_of_gaussian, int num_parts) {
  Hierarchy hierarchy;
  hierarchy.tree.num_leaves = num_parts;
  hierarchy.quality.assign(num_parts, 0.9);
  hierarchy.part_pixels.assign(num_parts, 100);
  hierarchy.total_pixels = 1000;
  hierarchy.part_of_gaussian = std::move(part_of_gaussian);
  return hierarchy;
}

TEST_F(EvidenceClusteringTest, TakesTheDivisionThatTheOthersAgreeWith) {
  ThreadPool pool(2);
  const std::vector<double> seen(6, 1.0);
  const Hierarchy odd = FromParts({0, 1, 0, 1, 0, 1}, 2);
  const Hierarchy usual = FromParts({0, 0, 0, 1, 1, 1}, 2);
  const Hierarchy similar = FromParts({0, 0, 0, 0, 1, 1}, 2);
  EXPECT_EQ(DivisionMostAgreedOn(
                std::vector<Hierarchy>{odd, similar, usual, usual}, seen, pool)
                .division,
            2u);
  const DivisionChoice same =
      DivisionMostAgreedOn(std::vector<Hierarchy>{odd, odd}, seen, pool);
  EXPECT_EQ(same.division, 0u);
  EXPECT_NEAR(same.agreement, 1, 1e-12);
  const DivisionChoice different =
      DivisionMostAgreedOn(std::vector<Hierarchy>{odd, usual}, seen, pool);
  EXPECT_LT(different.agreement, 0.6);
  EXPECT_GT(different.agreement, 0.3);
  EXPECT_EQ(
      DivisionMostAgreedOn(std::vector<Hierarchy>{odd}, seen, pool).agreement,
      0);
}

TEST_F(EvidenceClusteringTest, QualitiesAreTheMeanOfAllDivisions) {
  ThreadPool pool(2);
  const auto models = DefaultModels();
  ASSERT_TRUE(models.ok());
  // Two patches side by side, with no contact, in both divisions.
  ScenePatches patches;
  patches.patch_of_gaussian = {0, 0, 1, 1};
  patches.seen = {10, 10, 10, 10};
  patches.graph.regions.resize(2);
  for (RegionStats& region : patches.graph.regions) region.pixels = 20;
  patches.graph.total_pixels = 40;
  const std::vector<Hierarchy> alone =
      BuildHierarchies(std::vector<ScenePatches>{patches}, *models, pool);
  ScenePatches shifted = patches;
  shifted.patch_of_gaussian = {0, 1, 1, 1};
  const std::vector<Hierarchy> both = BuildHierarchies(
      std::vector<ScenePatches>{patches, shifted}, *models, pool);
  ASSERT_EQ(alone.size(), 1u);
  ASSERT_EQ(both.size(), 2u);
  ASSERT_GT(alone[0].quality[0], 0);
  // Half of the first patch is patch 0 of the other division; the second patch
  // is two thirds of patch 1 there.
  EXPECT_NEAR(both[0].quality[0], 0.75 * alone[0].quality[0], 2e-4);
  EXPECT_NEAR(
      both[0].quality[1], (1 + 2.0 / 3) / 2 * alone[0].quality[1], 2e-4);
}

TEST_F(EvidenceClusteringTest, RefusesAGranularityThatIsNoNumber) {
  EXPECT_EQ(Cluster(1, std::nan("")).status().code(),
            StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace freegs::semantics
