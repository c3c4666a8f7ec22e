// SPDX-License-Identifier: BSD-3-Clause
// Unary energies of a CRF from what is known of each pixel's label.

#ifndef FREEGS_SEMANTICS_CRF_UNARY_ENERGIES_H_
#define FREEGS_SEMANTICS_CRF_UNARY_ENERGIES_H_

#include <cstdint>

#include "core/image.h"
#include "core/status.h"

namespace freegs::semantics {

// A pixel whose label nobody knows.
constexpr uint16_t kUnknownLabel = 0xffff;

// Energies, W x H x num_labels, of labels, W x H, that are right with
// probability `confidence` and otherwise any other label alike: -log of
// confidence for the label, -log((1 - confidence) / (num_labels - 1)) for the
// others, and log(num_labels) for all where the label is kUnknownLabel.
// kInvalidArgument when there are no labels, labels has other than one channel
// or one outside [0, num_labels), num_labels is outside 1 .. 65535, or
// confidence is outside (0, 1).
StatusOr<ImageF> UnaryFromLabels(const ImageU16& labels,
                                 int num_labels,
                                 double confidence);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CRF_UNARY_ENERGIES_H_
