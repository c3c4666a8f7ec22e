// SPDX-License-Identifier: BSD-3-Clause

#include "bench/evidence/quality_learner.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "bench/evidence/logistic_regression.h"
#include "core/quantile.h"
#include "semantics/instances/hierarchy.h"

namespace freegs::evidence {
namespace {

using semantics::kNumRegionAttributes;
using semantics::QualityModel;
using semantics::RegionAttributes;

constexpr double kWholeIou = 0.6;
// This share of the examples at either end is taken for less extreme.
constexpr double kExtremes = 0.05;
// What keeps the weights small, for attributes of unit deviation.
constexpr double kRidge = 10;
constexpr int kQualitySteps = 20;
constexpr Eigen::Index kSize = kNumRegionAttributes + 1;

struct RegionExample {
  RegionAttributes attributes;
  bool whole = false;
  double weight = 1;
};

double BestIou(const LearningScene& scene,
               const std::map<int, double>& votes,
               double pixels) {
  double best = 0;
  for (const auto& [id, common] : votes) {
    const double both = pixels + scene.segment_pixels.at(id) - common;
    if (both > 0) best = std::max(best, common / both);
  }
  return best;
}

std::vector<RegionExample> ExamplesOf(
    const LearningScene& scene, const semantics::EvidenceModel& evidence) {
  const double crumb_size =
      semantics::CrumbSize(scene.patches.graph.total_pixels);
  const semantics::MeasuredTree measured = semantics::MergeAndMeasure(
      scene.patches.graph,
      semantics::EvidenceOfContacts(scene.patches.graph),
      evidence,
      crumb_size);
  const semantics::RegionTree& tree = measured.tree;
  const std::vector<double> sizes =
      tree.Sums(scene.patches.graph.PixelsOfRegions());
  const std::vector<double> pixels = tree.Sums(scene.pixels);
  std::vector<std::map<int, double>> votes = scene.votes;
  std::vector<double> outer(sizes.size(), 0.0);  // The size of the parent.
  for (const semantics::RegionTree::Merge& merge : tree.merges) {
    outer[merge.a] = outer[merge.b] = sizes[votes.size()];
    votes.push_back(SumOfVotes(votes[merge.a], votes[merge.b]));
  }
  constexpr double kLeastWeight = 0.02;
  std::vector<RegionExample> examples;
  for (size_t r = 0; r < sizes.size(); ++r) {
    if (!(sizes[r] >= crumb_size && pixels[r] > 0)) continue;
    const double share = outer[r] > 0 ? sizes[r] / outer[r] : 0;
    examples.push_back({measured.attributes[r],
                        BestIou(scene, votes[r], pixels[r]) > kWholeIou,
                        std::max(kLeastWeight, 1 - share)});
  }
  return examples;
}

void FindRanges(const std::vector<RegionExample>& examples,
                QualityModel* model) {
  for (size_t k = 0; k < kNumRegionAttributes; ++k) {
    std::vector<double> values;
    for (const RegionExample& example : examples) {
      values.push_back(example.attributes[k]);
    }
    model->least[k] = NearestQuantile(values, kExtremes);
    model->most[k] = NearestQuantile(std::move(values), 1 - kExtremes);
  }
}

// One column for each example: its attributes within the ranges, from 0 to 1,
// and a one.
Eigen::MatrixXd ColumnsOf(const std::vector<RegionExample>& examples,
                          const QualityModel& model) {
  Eigen::MatrixXd columns(kSize, static_cast<Eigen::Index>(examples.size()));
  for (size_t i = 0; i < examples.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    for (size_t k = 0; k < kNumRegionAttributes; ++k) {
      columns(static_cast<Eigen::Index>(k), column) =
          model.ShareOfRange(k, examples[i].attributes[k]);
    }
    columns(kSize - 1, column) = 1;
  }
  return columns;
}

}  // namespace

LearntQuality LearnQuality(std::span<const LearningScene> scenes,
                           const semantics::EvidenceModel& evidence,
                           ThreadPool& pool) {
  std::vector<std::vector<RegionExample>> of_scene(scenes.size());
  pool.ParallelFor(0,
                   static_cast<int64_t>(scenes.size()),
                   1,
                   [&](int64_t first, int64_t last, int) {
                     for (int64_t s = first; s < last; ++s) {
                       of_scene[s] = ExamplesOf(scenes[s], evidence);
                     }
                   });
  std::vector<RegionExample> examples;
  for (const std::vector<RegionExample>& more : of_scene) {
    examples.insert(examples.end(), more.begin(), more.end());
  }
  LearntQuality learnt;
  learnt.num_regions = examples.size();
  if (examples.empty()) return learnt;
  FindRanges(examples, &learnt.model);
  const Eigen::MatrixXd columns = ColumnsOf(examples, learnt.model);
  const Eigen::VectorXd mean = columns.rowwise().mean();
  Eigen::VectorXd ridge = kRidge *
                          (columns.colwise() - mean).rowwise().squaredNorm() /
                          static_cast<double>(examples.size());
  ridge = ridge.cwiseMax(1e-6);  // So that the system can always be solved.
  ridge[kSize - 1] = 1e-6;
  std::vector<LabelledExample> labels;
  for (const RegionExample& example : examples) {
    labels.push_back({example.whole, example.weight});
  }
  const Eigen::VectorXd weights =
      FitLogistic(columns, labels, ridge, kQualitySteps, pool);
  for (size_t k = 0; k < kNumRegionAttributes; ++k) {
    learnt.model.weight[k] = weights[static_cast<Eigen::Index>(k)];
  }
  learnt.model.bias = weights[kSize - 1];
  return learnt;
}

}  // namespace freegs::evidence
