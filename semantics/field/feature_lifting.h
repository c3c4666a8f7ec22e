// SPDX-License-Identifier: BSD-3-Clause
// Image features onto Gaussians in one pass and closed form: where FreeGS
// starts from random features and optimises (section "Multi-level 2D Semantic
// Distillation"), this is a start near the end, or an end in itself.

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
  std::vector<double> weights;  // N: sum of the blending weights, in pixels.
  size_t num_unseen = 0;        // Gaussians of weight 0.

  // False for a Gaussian that is blended onto no pixel of any view; its feature
  // is zero.
  bool seen(size_t gaussian) const { return weights[gaussian] > 0; }
};

// The image that a view's features are, at the size of its weights
// (store.camera(view)), H x W x channels. An error ends the lifting.
using ViewFeatures = FunctionRef<StatusOr<ImageF>(size_t view)>;

// f_i = sum_v sum_p W_v(p, i) F_v(p) / sum_v sum_p W_v(p, i): the mean of the
// features F of the pixels that Gaussian i is blended onto, by its blending
// weights W there, the least of
//   sum_v sum_p sum_i W_v(p, i) |F_v(p) - f_i|^2.
// By convexity that bounds the squared error of the blended features, F - W f,
// from above where rows of W sum to 1. (Uplifting by aggregation: LUDVIG,
// Marrie et al. 2024; no part of FreeGS, whose features it initialises.)
//
// Each view is asked for once, in order, so that the callback may compute,
// upsample and forget. Beside one view's features this takes N x channels
// floats. Numerators are summed in float (see AddMultiplyTransposed for the
// error), denominators in double. The same bytes for any number of threads.
//
// kInvalidArgument without views, and for features of another size than the
// view's weights, of differing channels or not finite; errors of the store and
// the callback.
StatusOr<LiftedFeatures> LiftFeatures(ViewWeightsStore& store,
                                      ViewFeatures features_of,
                                      ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_FEATURE_LIFTING_H_
