// SPDX-License-Identifier: BSD-3-Clause
// Learns how likely a region is a whole thing.

#ifndef FREEGS_BENCH_EVIDENCE_QUALITY_LEARNER_H_
#define FREEGS_BENCH_EVIDENCE_QUALITY_LEARNER_H_

#include <cstddef>
#include <span>

#include "bench/evidence/learning_scene.h"
#include "core/parallel.h"
#include "semantics/patches/evidence_model.h"
#include "semantics/patches/region_quality.h"

namespace freegs::evidence {

struct LearntQuality {
  semantics::QualityModel model;
  size_t num_regions = 0;  // That it was fitted to.
};

// Every region of the trees that `evidence` leads to, but crumbs and those that
// no view with true masks shows, is an example for a logistic regression: it is
// whole if its IoU with an object or a surface is above 0.6. Regions that are
// hardly smaller than what they are joined into count less, so that a chain of
// crumbs that join one thing does not count many times. The result is the same
// for any number of threads.
LearntQuality LearnQuality(std::span<const LearningScene> scenes,
                           const semantics::EvidenceModel& evidence,
                           ThreadPool& pool);

}  // namespace freegs::evidence

#endif  // FREEGS_BENCH_EVIDENCE_QUALITY_LEARNER_H_
