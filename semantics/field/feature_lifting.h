// SPDX-License-Identifier: BSD-3-Clause
// Averages image features onto Gaussians in one pass, in closed form. FreeGS
// optimises the vectors step by step ("Multi-level 2D Semantic Distillation"),
// from zero in its released code. This is a start that is close to the end, and
// it can serve as the result.

#ifndef FREEGS_SEMANTICS_FIELD_FEATURE_LIFTING_H_
#define FREEGS_SEMANTICS_FIELD_FEATURE_LIFTING_H_

#include <cstddef>
#include <vector>

#include "core/function_ref.h"
#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/field/view_weights_store.h"

namespace freegs::semantics {

struct LiftedFeatures {
  int channels = 0;
  std::vector<float> features;  // N x channels, row-major.
  std::vector<double> weights;  // N: sums of the blending weights over pixels.
  size_t num_unseen = 0;        // Number of Gaussians of weight 0.

  // False for a Gaussian that no view blends onto any pixel. Its feature is
  // zero.
  bool seen(size_t gaussian) const { return weights[gaussian] > 0; }
};

// Returns the feature image of a view, H x W x channels, at the size of its
// weights (store.camera(view)). An error ends the lifting.
using ViewFeatures = FunctionRef<StatusOr<ImageF>(size_t view)>;

// Returns, for each Gaussian i,
//   f_i = sum_v sum_p W_v(p, i) F_v(p) / sum_v sum_p W_v(p, i),
// the mean of the features F at the pixels onto which Gaussian i is blended, by
// its blending weights W there. It minimises
//   sum_v sum_p sum_i W_v(p, i) |F_v(p) - f_i|^2.
// By convexity this sum bounds the squared error of the blended features, F - W
// f, if the rows of W sum to 1. (The method is the aggregation of LUDVIG,
// Marrie et al. 2024. It is no part of FreeGS.)
//
// features_of is called once for each view in order, so that it may compute
// features and forget them. Beside the features of one view this takes N x
// channels floats. Numerators are summed in float (see AddMultiplyTransposed
// for the error), denominators in double. The result has the same bytes for any
// number of threads.
//
// kInvalidArgument for no views, and for features that are not finite, differ
// in channels, or have another size than the weights of their view. Errors of
// the store and of features_of.
StatusOr<LiftedFeatures> LiftFeatures(ViewWeightsStore& store,
                                      ViewFeatures features_of,
                                      ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_FEATURE_LIFTING_H_
