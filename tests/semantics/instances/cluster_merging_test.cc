// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/cluster_merging.h"

#include <vector>

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

// Rows of points along x: three pieces of one line, the last of another colour,
// and a far piece of the first colour.
struct Line {
  std::vector<float> positions;
  std::vector<float> colors;
  std::vector<int32_t> labels;

  void Add(double start, int32_t label, float red) {
    for (int i = 0; i < 50; ++i) {
      positions.insert(positions.end(),
                       {static_cast<float>(start + 0.01 * i), 0.0f, 0.0f});
      colors.insert(colors.end(), {red, 0.0f, 0.0f});
      labels.push_back(label);
    }
  }
};

Line MakeLine() {
  Line line;
  line.Add(0.0, 2, 0.50f);
  line.Add(0.5, 0, 0.52f);
  line.Add(1.0, 1, 0.90f);
  line.Add(5.0, 3, 0.50f);
  return line;
}

TEST(ClusterMergingTest, JoinsTouchingClustersOfOneColour) {
  Line line = MakeLine();
  ThreadPool pool(2);
  MergeClusters(line.positions, line.colors, 0.015, 0.1, pool, &line.labels);
  EXPECT_EQ(line.labels[0], 0);
  EXPECT_EQ(line.labels[50], 0);
  EXPECT_EQ(line.labels[100], 1);
  EXPECT_EQ(line.labels[150], 3);
}

TEST(ClusterMergingTest, JoinsNothingThatIsApart) {
  Line line = MakeLine();
  const std::vector<int32_t> before = line.labels;
  ThreadPool pool(1);
  MergeClusters(line.positions, line.colors, 0.005, 10, pool, &line.labels);
  EXPECT_EQ(line.labels, before);
}

TEST(ClusterMergingTest, NoiseTakesTheNearestLabelWithinReach) {
  Line line = MakeLine();
  line.labels[10] = -1;  // Inside the piece of label 2.
  line.positions.insert(line.positions.end(), {1.6f, 0, 0, 3.2f, 0, 0});
  line.labels.insert(line.labels.end(), {-1, -1});
  ThreadPool pool(2);
  LabelNoise(line.positions, 0.2, pool, &line.labels);
  EXPECT_EQ(line.labels[10], 2);
  EXPECT_EQ(line.labels[200], 1);
  EXPECT_EQ(line.labels[201], -1);
}

TEST(ClusterMergingTest, NothingLabelled) {
  std::vector<int32_t> labels(3, -1);
  const std::vector<float> positions(9, 0.0f);
  ThreadPool pool(1);
  LabelNoise(positions, 1, pool, &labels);
  MergeClusters(positions, positions, 1, 1, pool, &labels);
  EXPECT_EQ(labels, std::vector<int32_t>(3, -1));
  std::vector<int32_t> none;
  LabelNoise({}, 1, pool, &none);
  MergeClusters({}, {}, 1, 1, pool, &none);
}

}  // namespace
}  // namespace freegs::semantics
