// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bootstrap/instance_doubts.h"

#include <iomanip>
#include <numeric>
#include <sstream>

namespace freegs::stages {
namespace {

// One or two instances are hardly ever the things of a scene. In the union
// space, a few more are halves of a scene and crumbs.
constexpr int kFewInstances = 2;
constexpr int kFewInstancesOfUnion = 5;

// Instances with a smaller mean score were mostly wrong, on drawn scenes
// (docs/instances.md).
constexpr double kUnsureScore = 0.1;

std::string FewInstances(int count, bool union_space) {
  return std::string("only ") +
         (count == 1 ? "one instance was"
                     : std::to_string(count) + " instances were") +
         " found, so that things of the scene may be joined; try " +
         (union_space ? "bootstrap.clustering evidence, or other values of "
                        "bootstrap.min_cluster_size, bootstrap.min_samples and "
                        "bootstrap.semantic_weight"
                      : "a larger bootstrap.granularity");
}

std::string UnsureInstances(double mean_score) {
  std::ostringstream text;
  text << "the instances are unsure, with a mean score of "
       << std::setprecision(2) << mean_score << " (below " << kUnsureScore
       << "): many may be parts of things, or several things; look at "
          "bootstrap/preview, and take sharp photos in even light from more "
          "sides";
  return text.str();
}

}  // namespace

double MeanScore(const semantics::InstanceLabels& labels) {
  if (labels.scores.empty()) return 0;
  return std::accumulate(labels.scores.begin(), labels.scores.end(), 0.0) /
         static_cast<double>(labels.scores.size());
}

std::vector<std::string> DoubtsAbout(const semantics::InstanceLabels& labels,
                                     bool union_space) {
  std::vector<std::string> doubts;
  if (labels.num_instances <=
      (union_space ? kFewInstancesOfUnion : kFewInstances)) {
    doubts.push_back(FewInstances(labels.num_instances, union_space));
  }
  if (!union_space && MeanScore(labels) < kUnsureScore) {
    doubts.push_back(UnsureInstances(MeanScore(labels)));
  }
  return doubts;
}

}  // namespace freegs::stages
