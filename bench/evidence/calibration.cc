// SPDX-License-Identifier: BSD-3-Clause

#include "bench/evidence/calibration.h"

#include <algorithm>
#include <cmath>

#include "semantics/instances/hierarchy.h"

namespace freegs::evidence {
namespace {

constexpr int kCalibrationSteps = 40;

}  // namespace

std::vector<JudgedMerge> JudgeMerges(const LearningScene& scene,
                                     const semantics::EvidenceModel& model) {
  const semantics::RegionTree tree = semantics::MergeRegions(
      scene.patches.graph,
      [&](const semantics::Evidence& e) { return model.Difference(e); });
  const double crumb_size =
      semantics::CrumbSize(scene.patches.graph.total_pixels);
  const std::vector<double> sizes =
      tree.Sums(scene.patches.graph.PixelsOfRegions());
  const std::vector<double> pixels = tree.Sums(scene.pixels);
  std::vector<std::map<int, double>> votes = scene.votes;
  std::vector<JudgedMerge> judged;
  for (const semantics::RegionTree::Merge& merge : tree.merges) {
    const int a = TrueSegment(votes[merge.a], pixels[merge.a]);
    const int b = TrueSegment(votes[merge.b], pixels[merge.b]);
    if (std::min(sizes[merge.a], sizes[merge.b]) >= crumb_size &&
        std::min(pixels[merge.a], pixels[merge.b]) > 0) {
      judged.push_back({merge.height, a < 0 || a != b});
    }
    votes.push_back(SumOfVotes(votes[merge.a], votes[merge.b]));
  }
  return judged;
}

Calibration FitCalibration(std::span<const JudgedMerge> merges) {
  const auto num_different =
      std::count_if(merges.begin(), merges.end(), [](const JudgedMerge& merge) {
        return merge.different;
      });
  if (num_different == 0 ||
      num_different == static_cast<int64_t>(merges.size())) {
    return {};
  }
  Calibration fit;
  for (int step = 0; step < kCalibrationSteps; ++step) {
    // A little is added so that the system can always be solved.
    double slope_slope = 1e-6;
    double slope_offset = 0;
    double offset_offset = 1e-6;
    double slope = 0;
    double offset = 0;
    for (const JudgedMerge& merge : merges) {
      const double p =
          1 / (1 + std::exp(-fit.slope * merge.height - fit.offset));
      const double off = p - (merge.different ? 1 : 0);
      slope += off * merge.height;
      offset += off;
      slope_slope += p * (1 - p) * merge.height * merge.height;
      slope_offset += p * (1 - p) * merge.height;
      offset_offset += p * (1 - p);
    }
    const double determinant =
        slope_slope * offset_offset - slope_offset * slope_offset;
    fit.slope -= (offset_offset * slope - slope_offset * offset) / determinant;
    fit.offset -= (slope_slope * offset - slope_offset * slope) / determinant;
  }
  if (!(fit.slope > 0) || !std::isfinite(fit.slope + fit.offset)) return {};
  return fit;
}

semantics::EvidenceModel Calibrated(semantics::EvidenceModel model,
                                    const Calibration& calibration) {
  for (double& weight : model.weight) weight *= calibration.slope;
  model.bias = calibration.slope * model.bias + calibration.offset;
  return model;
}

}  // namespace freegs::evidence
