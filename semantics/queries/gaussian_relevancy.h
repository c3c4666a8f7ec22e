// SPDX-License-Identifier: BSD-3-Clause
// Answers a text without instances: each Gaussian answers for itself.

#ifndef FREEGS_SEMANTICS_QUERIES_GAUSSIAN_RELEVANCY_H_
#define FREEGS_SEMANTICS_QUERIES_GAUSSIAN_RELEVANCY_H_

#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"
#include "semantics/field/idsf.h"
#include "semantics/losses/feature_decoder.h"

namespace freegs::semantics {

// Returns the relevancy (clip/relevancy.h) of each of N Gaussians to each of T
// texts, N x T, row-major. It is 0 for Gaussians that no view showed, whose
// vectors are zero. texts (T x C) and canonical hold vectors of length 1, one
// after another. The result has the same bytes for any number of threads.
// kInvalidArgument if sizes disagree.
StatusOr<std::vector<float>> GaussianRelevancy(const Idsf& field,
                                               const FeatureDecoder& decoder,
                                               std::span<const float> texts,
                                               std::span<const float> canonical,
                                               ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_QUERIES_GAUSSIAN_RELEVANCY_H_
