// SPDX-License-Identifier: BSD-3-Clause
// What evidence is worth: a logistic regression, learnt from drawn scenes whose
// truth is known (scripts/fit_evidence.sh).

#ifndef FREEGS_SEMANTICS_PATCHES_EVIDENCE_MODEL_H_
#define FREEGS_SEMANTICS_PATCHES_EVIDENCE_MODEL_H_

#include <array>
#include <string>
#include <string_view>

#include "core/status.h"
#include "semantics/patches/evidence.h"

namespace freegs::semantics {

struct EvidenceModel {
  // For each evidence: its mean and its standard deviation among the examples,
  // and its weight.
  std::array<double, kNumEvidences> mean = {};
  std::array<double, kNumEvidences> deviation = {};
  std::array<double, kNumEvidences> weight = {};
  double bias = 0;

  // Log-odds of being two things.
  double Difference(const Evidence& evidence) const {
    double sum = bias;
    for (size_t k = 0; k < kNumEvidences; ++k) {
      sum += weight[k] * (evidence[k] - mean[k]) / deviation[k];
    }
    return sum;
  }
};

// {"bias": -5.5, "evidence": [{"name": "contrast_near", "mean": 0.31,
// "deviation": 0.2, "weight": 0.47}, ...]}; other members are ignored.
// kBadInput for malformed text, for evidence that is missing or unknown, and
// for deviations that are not positive.
StatusOr<EvidenceModel> ParseEvidenceModel(std::string_view text);

// The model that comes with the library: evidence.json beside this file.
StatusOr<EvidenceModel> DefaultEvidenceModel();

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_EVIDENCE_MODEL_H_
