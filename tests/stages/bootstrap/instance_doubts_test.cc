// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bootstrap/instance_doubts.h"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

semantics::InstanceLabels WithScores(std::vector<double> scores) {
  semantics::InstanceLabels labels;
  labels.num_instances = static_cast<int>(scores.size());
  labels.scores = std::move(scores);
  return labels;
}

TEST(InstanceDoubtsTest, NoneAboutSureInstances) {
  EXPECT_TRUE(DoubtsAbout(WithScores({0.9, 0.1, 0.2}), false).empty());
}

TEST(InstanceDoubtsTest, AboutInstancesThatAreHardlyWholeThings) {
  const auto labels = WithScores({0.25, 0.01, 0.05, 0.01});
  EXPECT_DOUBLE_EQ(MeanScore(labels), 0.08);
  const auto doubts = DoubtsAbout(labels, false);
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_NE(doubts[0].find("mean score of 0.08 (below 0.1)"), std::string::npos)
      << doubts[0];
}

TEST(InstanceDoubtsTest, AboutFewInstances) {
  const auto doubts = DoubtsAbout(WithScores({0.9}), false);
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_NE(doubts[0].find("only one instance was found"), std::string::npos)
      << doubts[0];
  EXPECT_NE(doubts[0].find("bootstrap.granularity"), std::string::npos);
}

TEST(InstanceDoubtsTest, UnionHasMoreInstancesAndOtherScores) {
  const auto few = WithScores({0, 0, 0, 0, 0});
  const auto doubts = DoubtsAbout(few, true);
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_NE(doubts[0].find("only 5 instances were found"), std::string::npos)
      << doubts[0];
  EXPECT_NE(doubts[0].find("bootstrap.clustering evidence"), std::string::npos);
  EXPECT_TRUE(DoubtsAbout(WithScores({0, 0, 0, 0, 0, 0}), true).empty());
}

}  // namespace
}  // namespace freegs::stages
