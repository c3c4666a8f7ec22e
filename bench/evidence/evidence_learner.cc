// SPDX-License-Identifier: BSD-3-Clause

#include "bench/evidence/evidence_learner.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Core>

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
          std::map<int, double> sum = votes[a];
          for (const auto& [id, count] : votes[b]) sum[id] += count;
          votes.push_back(std::move(sum));
          pixels.push_back(pixels[a] + pixels[b]);
        }
        return join;
      };
  semantics::MergeRegions(scene.graph, difference, allow);
}

// Mean and deviation of each evidence.
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

EvidenceModel FitEvidence(std::span<const Example> examples,
                          const std::set<std::string>& without,
                          ThreadPool& pool) {
  // Newton's method.
  EvidenceModel model = Normalised(examples);
  constexpr Eigen::Index n = kNumEvidences + 1;
  const auto row = [&](const Evidence& evidence) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
    for (size_t k = 0; k < kNumEvidences; ++k) {
      if (!without.contains(semantics::kEvidenceNames[k])) {
        x[k] = (evidence[k] - model.mean[k]) / model.deviation[k];
      }
    }
    x[n - 1] = 1;
    return x;
  };
  constexpr int64_t kPart = 4096;
  const auto count = static_cast<int64_t>(examples.size());
  const int64_t parts = (count + kPart - 1) / kPart;
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(n);
  for (int step = 0; step < kNewtonSteps; ++step) {
    // Sums in parts of a fixed size do not depend on the threads.
    std::vector<Eigen::VectorXd> gradients(parts);
    std::vector<Eigen::MatrixXd> hessians(parts);
    pool.ParallelFor(0, parts, 1, [&](int64_t first, int64_t last, int) {
      for (int64_t part = first; part < last; ++part) {
        Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
        const int64_t begin = part * kPart;
        const int64_t end = std::min(count, begin + kPart);
        Eigen::MatrixXd rows(n, end - begin);
        for (int64_t i = begin; i < end; ++i) {
          const Eigen::VectorXd x = row(examples[i].evidence);
          const double p = 1 / (1 + std::exp(-weights.dot(x)));
          gradient +=
              examples[i].weight * (p - (examples[i].different ? 1 : 0)) * x;
          rows.col(i - begin) = std::sqrt(examples[i].weight * p * (1 - p)) * x;
        }
        hessians[part] = rows * rows.transpose();
        gradients[part] = gradient;
      }
    });
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Identity(n, n);
    Eigen::VectorXd gradient = weights;
    for (int64_t part = 0; part < parts; ++part) {
      hessian += hessians[part];
      gradient += gradients[part];
    }
    weights -= hessian.ldlt().solve(gradient);
  }
  for (size_t k = 0; k < kNumEvidences; ++k) model.weight[k] = weights[k];
  model.bias = weights[n - 1];
  return model;
}

namespace {

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

LearntEvidence LearnEvidence(std::span<const LearningScene> scenes,
                             const std::set<std::string>& without,
                             ThreadPool& pool) {
  LearntEvidence learnt = LearnWeights(scenes, without, pool);
  const std::span<const LearningScene> halves[] = {
      scenes.first(scenes.size() / 2), scenes.subspan(scenes.size() / 2)};
  std::vector<JudgedMerge> merges;
  for (const int half : {0, 1}) {
    if (halves[half].empty()) continue;
    const EvidenceModel model = LearnWeights(halves[half], without, pool).model;
    for (const LearningScene& scene : halves[1 - half]) {
      const std::vector<JudgedMerge> more = JudgeMerges(scene, model);
      merges.insert(merges.end(), more.begin(), more.end());
    }
  }
  learnt.calibration = FitCalibration(merges);
  learnt.model = Calibrated(learnt.model, learnt.calibration);
  return learnt;
}

}  // namespace freegs::evidence
