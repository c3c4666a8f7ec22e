// SPDX-License-Identifier: BSD-3-Clause
// Pixel-level feature distillation (FreeGS eq. 8, first term).

#ifndef FREEGS_SEMANTICS_LOSSES_PIXEL_DISTILLATION_LOSS_H_
#define FREEGS_SEMANTICS_LOSSES_PIXEL_DISTILLATION_LOSS_H_

#include <span>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

// Returns L = sum_p w_p |F_p - T_p|_1 / (C sum_p w_p), the mean absolute
// difference of the decoded features F to the image features T of S sampled
// pixels, and adds weight dL/dF to `gradients`. 0 for no pixels.
//   decoded    F, S x C, row-major
//   targets    T, S x C
//   row_weights  w, S, >= 0, say how much of each pixel Gaussians cover; empty:
//              all 1
//   gradients  S x C
//
// FreeGS brings F from the size of the photographs down to that of T with a
// learnt convolution. Here latents are blended at the size of T, so that pixel
// p of both is the same pixel and there is nothing to learn. The mean, where
// eq. 8 has a norm, keeps the weights of losses free of S and C.
//
// kInvalidArgument for sizes that disagree, row weights out of range and values
// that are not finite.
StatusOr<double> PixelDistillationLoss(std::span<const float> decoded,
                                       std::span<const float> targets,
                                       int channels,
                                       double weight,
                                       ThreadPool& pool,
                                       std::span<float> gradients);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_PIXEL_DISTILLATION_LOSS_H_
