// SPDX-License-Identifier: BSD-3-Clause
// Unary energies of a CRF from what is known of each pixel's label.

#ifndef FREEGS_SEMANTICS_CRF_UNARY_ENERGIES_H_
#define FREEGS_SEMANTICS_CRF_UNARY_ENERGIES_H_

#include <cstdint>

#include "core/image.h"
#include "core/status.h"

namespace freegs::semantics {

// The label of a pixel of which nothing is known.
inline constexpr uint16_t kUnknownLabel = 0xffff;

// Returns energies, W x H x num_labels. A label of `labels`, W x H, is right
// with probability `confidence`; all other labels are equally probable. So the
// energy is -log(confidence) for the given label and -log((1 - confidence) /
// (num_labels - 1)) for the others. It is log(num_labels) for all labels where
// the given one is kUnknownLabel.
//
// kInvalidArgument for an empty image or one of several channels, for a label
// that is not in 0 .. num_labels - 1, for num_labels outside 1 .. 65535, and
// for a confidence outside (0, 1).
StatusOr<ImageF> UnaryFromLabels(const ImageU16& labels,
                                 int num_labels,
                                 double confidence);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CRF_UNARY_ENERGIES_H_
