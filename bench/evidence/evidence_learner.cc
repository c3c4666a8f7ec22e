// SPDX-License-Identifier: BSD-3-Clause

#include "bench/evidence/evidence_learner.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Core>

#include "bench/evidence/logistic_regression.h"
#include "core/text.h"
#include "semantics/patches/region_merging.h"

namespace freegs::evidence {
namespace {

using semantics::Evidence;
using semantics::EvidenceModel;
using semantics::kNumEvidences;

constexpr int kRounds = 3;
constexpr int kNewtonSteps = 8;
// More examples than this tell little more; an even share of them is taken.
constexpr size_t kMaxExamples = 200000;

// Adds the pairs of a scene that the difference leads to.
void Collect(const LearningScene& scene,
             const semantics::DifferenceFn& difference,
             bool own_mistakes,
             std::vector<Example>* examples) {
  std::vector<std::map<int, double>> votes = scene.votes;
  std::vector<double> pixels = scene.pixels;
  const semantics::AllowFn allow =
      [&](int32_t a, int32_t b, const Evidence& e) {
        const int sa = TrueSegment(votes[a], pixels[a]);
        const int sb = TrueSegment(votes[b], pixels[b]);
        // Nobody knows of what is of no segment; it grows so that others go on.
        bool join = sa < 0 && sb < 0;
        if (sa >= 0 && sb >= 0) {
          join = sa == sb;
          // Joining large regions wrongly does more harm: the root of the small
          // region's pixels.
          const double root = std::pow(10.0, 0.5 * (e[semantics::kSize] + 4));
          examples->push_back({e, !join, root});
          if (own_mistakes) join = difference(e) <= 0;
        }
        if (join) {
          votes.push_back(SumOfVotes(votes[a], votes[b]));
          pixels.push_back(pixels[a] + pixels[b]);
        }
        return join;
      };
  semantics::MergeRegions(scene.patches.graph, difference, allow);
}

// Mean and deviation of each evidence. At least one example.
EvidenceModel Normalised(std::span<const Example> examples) {
  EvidenceModel model;
  const auto count = static_cast<double>(examples.size());
  for (size_t k = 0; k < kNumEvidences; ++k) {
    double sum = 0;
    double square = 0;
    for (const Example& example : examples) {
      sum += example.evidence[k];
      square += double{example.evidence[k]} * example.evidence[k];
    }
    model.mean[k] = sum / count;
    model.deviation[k] = std::sqrt(
        std::max(1e-8, square / count - model.mean[k] * model.mean[k]));
  }
  return model;
}

}  // namespace

Status CheckEvidenceNames(const std::vector<std::string>& names) {
  const std::vector<std::string> known(semantics::kEvidenceNames.begin(),
                                       semantics::kEvidenceNames.end());
  for (const std::string& name : names) {
    if (std::ranges::find(known, name) != known.end()) continue;
    return InvalidArgumentError("there is no evidence \"" + name +
                                "\"; there are " + Joined(known));
  }
  return Status();
}

EvidenceModel FitEvidence(std::span<const Example> examples,
                          const std::set<std::string>& without,
                          ThreadPool& pool) {
  EvidenceModel model = Normalised(examples);
  constexpr Eigen::Index n = kNumEvidences + 1;
  Eigen::MatrixXd columns =
      Eigen::MatrixXd::Zero(n, static_cast<Eigen::Index>(examples.size()));
  std::vector<LabelledExample> labels;
  for (const Example& example : examples) {
    auto column = columns.col(static_cast<Eigen::Index>(labels.size()));
    for (size_t k = 0; k < kNumEvidences; ++k) {
      if (!without.contains(semantics::kEvidenceNames[k])) {
        column[static_cast<Eigen::Index>(k)] =
            (example.evidence[k] - model.mean[k]) / model.deviation[k];
      }
    }
    column[n - 1] = 1;
    labels.push_back({example.different, example.weight});
  }
  const Eigen::VectorXd weights = FitLogistic(
      columns, labels, Eigen::VectorXd::Ones(n), kNewtonSteps, pool);
  for (size_t k = 0; k < kNumEvidences; ++k) model.weight[k] = weights[k];
  model.bias = weights[n - 1];
  return model;
}

namespace {

// Without an example nothing is learnt: num_examples is 0.
LearntEvidence LearnWeights(std::span<const LearningScene> scenes,
                            const std::set<std::string>& without,
                            ThreadPool& pool) {
  LearntEvidence learnt;
  std::vector<Example> examples;
  for (int round = 0; round < kRounds; ++round) {
    const bool first_round = round == 0;
    const semantics::DifferenceFn difference = [&](const Evidence& e) {
      return first_round ? double{e[semantics::kContrastFar]} +
                               e[semantics::kHistogram] + e[semantics::kColor]
                         : learnt.model.Difference(e);
    };
    std::vector<std::vector<Example>> of_scene(scenes.size());
    pool.ParallelFor(0,
                     static_cast<int64_t>(scenes.size()),
                     1,
                     [&](int64_t first, int64_t last, int) {
                       for (int64_t s = first; s < last; ++s) {
                         if (!first_round) {
                           Collect(scenes[s], difference, true, &of_scene[s]);
                         }
                         Collect(scenes[s], difference, false, &of_scene[s]);
                       }
                     });
    for (const std::vector<Example>& more : of_scene) {
      examples.insert(examples.end(), more.begin(), more.end());
    }
    if (examples.empty()) return learnt;
    std::vector<Example> share;
    const size_t step = examples.size() / kMaxExamples + 1;
    for (size_t i = 0; i < examples.size(); i += step) {
      share.push_back(examples[i]);
    }
    learnt.model = FitEvidence(share, without, pool);
    learnt.share = std::move(share);
  }
  learnt.num_examples = examples.size();
  return learnt;
}

}  // namespace

StatusOr<LearntEvidence> LearnEvidence(std::span<const LearningScene> scenes,
                                       const std::set<std::string>& without,
                                       ThreadPool& pool) {
  LearntEvidence learnt = LearnWeights(scenes, without, pool);
  if (learnt.num_examples == 0) {
    return BadInputError(
        "nothing to learn evidence from: no two patches that touch are known "
        "to be of one thing or of two");
  }
  const std::span<const LearningScene> halves[] = {
      scenes.first(scenes.size() / 2), scenes.subspan(scenes.size() / 2)};
  std::vector<JudgedMerge> merges;
  for (const int half : {0, 1}) {
    const LearntEvidence part = LearnWeights(halves[half], without, pool);
    if (part.num_examples == 0) continue;
    for (const LearningScene& scene : halves[1 - half]) {
      const std::vector<JudgedMerge> more = JudgeMerges(scene, part.model);
      merges.insert(merges.end(), more.begin(), more.end());
    }
  }
  learnt.calibration = FitCalibration(merges);
  learnt.model = Calibrated(learnt.model, learnt.calibration);
  return learnt;
}

}  // namespace freegs::evidence
