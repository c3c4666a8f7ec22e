// SPDX-License-Identifier: BSD-3-Clause
// Distillation of pixel features: the first term of FreeGS eq. 7.

#ifndef FREEGS_SEMANTICS_LOSSES_PIXEL_DISTILLATION_LOSS_H_
#define FREEGS_SEMANTICS_LOSSES_PIXEL_DISTILLATION_LOSS_H_

#include <span>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

// Returns L = sum_p |F_p - T_p|_1 / (C S), the mean absolute difference between
// the decoded features F and the image features T at S sampled pixels, and adds
// weight dL/dF to `gradients`. L is 0 for no pixels.
//   decoded    F, S x C, row-major
//   targets    T, S x C
//   gradients  S x C
//
// FreeGS brings F from the size of the photographs to that of T by a learnt
// convolution. Here latents are blended at the size of T, so that no
// convolution is needed. The mean, where eq. 7 has a norm, makes the weights of
// the losses independent of S and C.
//
// kInvalidArgument for sizes that disagree and values that are not finite.
StatusOr<double> PixelDistillationLoss(std::span<const float> decoded,
                                       std::span<const float> targets,
                                       int channels,
                                       double weight,
                                       ThreadPool& pool,
                                       std::span<float> gradients);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_PIXEL_DISTILLATION_LOSS_H_
