// SPDX-License-Identifier: BSD-3-Clause

#include "bench/evidence/quality_learner.h"

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::evidence {
namespace {

constexpr int kObjects = 4;
constexpr double kPixels = 1000;  // Pixels of each patch.

// The more contrast there is, the likelier two regions are two things.
semantics::EvidenceModel ContrastTells() {
  semantics::EvidenceModel model;
  model.deviation.fill(1);
  model.weight[semantics::kContrastNear] = 20;
  model.bias = -10;
  return model;
}

// Patches in a row, two of each object, with little contrast inside objects
// and much between them.
LearningScene Row(uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> jitter(-0.15, 0.15);
  LearningScene scene;
  scene.patches.graph.total_pixels = 2 * kObjects * kPixels;
  for (int32_t i = 0; i < 2 * kObjects; ++i) {
    semantics::RegionStats region;
    region.pixels = kPixels;
    scene.patches.graph.regions.push_back(region);
    scene.pixels.push_back(kPixels);
    const int object = i / 2 + 1;
    scene.votes.push_back({{object, kPixels}});
    scene.segment_pixels[object] += kPixels;
    if (i == 0) continue;
    semantics::ContactStats contact;
    contact.pixels = 10;
    contact.contrast_near =
        contact.pixels * ((i % 2 == 1 ? 0.3 : 0.7) + jitter(random));
    scene.patches.graph.contacts.push_back({i - 1, i, contact});
  }
  return scene;
}

std::vector<LearningScene> Rows(int count) {
  std::vector<LearningScene> scenes;
  for (int i = 0; i < count; ++i) {
    scenes.push_back(Row(static_cast<uint32_t>(i)));
  }
  return scenes;
}

TEST(QualityLearnerTest, WholeThingsGetMoreThanPartsAndGroups) {
  ThreadPool pool(2);
  const std::vector<LearningScene> scenes = Rows(40);
  const LearntQuality learnt = LearnQuality(scenes, ContrastTells(), pool);
  // Every patch, and one region fewer that is joined of others.
  EXPECT_EQ(learnt.num_regions, 40u * (4 * kObjects - 1));

  // A row that it was not taught.
  const semantics::RegionGraph graph = Row(1000).patches.graph;
  const semantics::MeasuredTree measured = semantics::MergeAndMeasure(
      graph, semantics::EvidenceOfContacts(graph), ContrastTells(), 1);
  const std::vector<double> sizes = measured.tree.Sums(graph.PixelsOfRegions());
  double least_of_wholes = 1;
  double most_of_others = 0;
  int wholes = 0;
  for (size_t r = 0; r < sizes.size(); ++r) {
    const double quality = learnt.model.Probability(measured.attributes[r]);
    if (sizes[r] == 2 * kPixels) {
      least_of_wholes = std::min(least_of_wholes, quality);
      ++wholes;
    } else {
      most_of_others = std::max(most_of_others, quality);
    }
  }
  EXPECT_EQ(wholes, kObjects);
  EXPECT_GT(least_of_wholes, 0.5);
  EXPECT_LT(most_of_others, 0.5);
}

TEST(QualityLearnerTest, OnlyRegionsThatAreSeenAreExamples) {
  ThreadPool pool(1);
  LearningScene scene = Row(1);
  scene.pixels[0] = 0;
  scene.votes[0].clear();
  EXPECT_EQ(LearnQuality({&scene, 1}, ContrastTells(), pool).num_regions,
            4u * kObjects - 2);
  // A crumb, which is less than a thousandth of all pixels.
  scene.patches.graph.regions[2].pixels = 1;
  EXPECT_EQ(LearnQuality({&scene, 1}, ContrastTells(), pool).num_regions,
            4u * kObjects - 3);
  std::fill(scene.pixels.begin(), scene.pixels.end(), 0.0);
  EXPECT_EQ(LearnQuality({&scene, 1}, ContrastTells(), pool).num_regions, 0u);
  EXPECT_EQ(LearnQuality({}, ContrastTells(), pool).num_regions, 0u);
}

TEST(QualityLearnerTest, IsTheSameForAnyNumberOfThreads) {
  const std::vector<LearningScene> scenes = Rows(5);
  ThreadPool one(1);
  ThreadPool three(3);
  const semantics::QualityModel a =
      LearnQuality(scenes, ContrastTells(), one).model;
  const semantics::QualityModel b =
      LearnQuality(scenes, ContrastTells(), three).model;
  EXPECT_EQ(a.weight, b.weight);
  EXPECT_EQ(a.bias, b.bias);
  EXPECT_EQ(a.least, b.least);
  EXPECT_EQ(a.most, b.most);
}

}  // namespace
}  // namespace freegs::evidence
