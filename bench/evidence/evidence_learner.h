// SPDX-License-Identifier: BSD-3-Clause
// Learns how evidence speaks for or against one thing.

#ifndef FREEGS_BENCH_EVIDENCE_EVIDENCE_LEARNER_H_
#define FREEGS_BENCH_EVIDENCE_EVIDENCE_LEARNER_H_

#include <cstddef>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "bench/evidence/calibration.h"
#include "bench/evidence/learning_scene.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/patches/evidence.h"
#include "semantics/patches/evidence_model.h"

namespace freegs::evidence {

// kInvalidArgument tells which of the names is of no evidence.
Status CheckEvidenceNames(const std::vector<std::string>& names);

// Two regions that touch, and whether they are of different things.
struct Example {
  semantics::Evidence evidence;
  bool different = false;
  double weight = 1;
};

struct LearntEvidence {
  semantics::EvidenceModel model;  // Calibrated.
  Calibration calibration;
  size_t num_examples = 0;
  std::vector<Example> share;  // Those of them that the model was fitted to.
};

// Merges each scene's patches several times, as the model of the round before
// says: once only as far as the truth allows and, from the second round on,
// once as its own mistakes lead (Nunez-Iglesias et al. 2013). Every pair that
// is asked about on the way is an example for a logistic regression. The height
// of a merge is the largest of many differences, so it overstates the odds;
// merges in each half of the scenes, by what was learnt from the other half,
// say by how much. The same scenes give the same model for any number of
// threads. `without` names evidence that gets no weight. kBadInput where the
// scenes have no example.
StatusOr<LearntEvidence> LearnEvidence(std::span<const LearningScene> scenes,
                                       const std::set<std::string>& without,
                                       ThreadPool& pool);

// The regression alone, not calibrated. At least one example.
semantics::EvidenceModel FitEvidence(std::span<const Example> examples,
                                     const std::set<std::string>& without,
                                     ThreadPool& pool);

}  // namespace freegs::evidence

#endif  // FREEGS_BENCH_EVIDENCE_EVIDENCE_LEARNER_H_
