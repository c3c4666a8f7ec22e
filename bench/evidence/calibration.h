// SPDX-License-Identifier: BSD-3-Clause
// How far the heights of a merge tree are the log-odds that they stand for.

#ifndef FREEGS_BENCH_EVIDENCE_CALIBRATION_H_
#define FREEGS_BENCH_EVIDENCE_CALIBRATION_H_

#include <span>
#include <vector>

#include "bench/evidence/learning_scene.h"
#include "semantics/patches/evidence_model.h"

namespace freegs::evidence {

// A merge of two regions, none of them a crumb, and whether it made more than
// one thing: the two are of different true segments, or one is a mixture.
struct JudgedMerge {
  double height = 0;
  bool different = false;
};

// Log-odds are slope * height + offset.
struct Calibration {
  double slope = 1;
  double offset = 0;
};

// The merges that a model leads to in a scene, without those of a region that
// no view with true masks shows.
std::vector<JudgedMerge> JudgeMerges(const LearningScene& scene,
                                     const semantics::EvidenceModel& model);

// Logistic regression (Platt 1999). The identity if one kind is missing or
// heights do not tell them apart.
Calibration FitCalibration(std::span<const JudgedMerge> merges);

// The model whose difference is the calibrated one.
semantics::EvidenceModel Calibrated(semantics::EvidenceModel model,
                                    const Calibration& calibration);

}  // namespace freegs::evidence

#endif  // FREEGS_BENCH_EVIDENCE_CALIBRATION_H_
