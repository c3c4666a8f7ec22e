// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/crf/unary_energies.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace freegs::semantics {

StatusOr<ImageF> UnaryFromLabels(const ImageU16& labels,
                                 int num_labels,
                                 double confidence) {
  if (labels.empty() || labels.channels() != 1) {
    return InvalidArgumentError(
        "unary energies need one label per pixel of an image that is not "
        "empty");
  }
  if (num_labels < 1 || num_labels > kUnknownLabel) {
    return InvalidArgumentError("the number of labels must lie in 1 .. " +
                                std::to_string(kUnknownLabel));
  }
  if (!(confidence > 0 && confidence < 1)) {
    return InvalidArgumentError(
        "the confidence in labels must lie between 0 and 1");
  }
  // A single label is certain.
  const auto right =
      static_cast<float>(num_labels == 1 ? 0.0 : -std::log(confidence));
  const auto wrong =
      static_cast<float>(-std::log((1 - confidence) / (num_labels - 1)));
  const auto unknown = static_cast<float>(std::log(num_labels));
  ImageF unary(labels.width(), labels.height(), num_labels);
  for (size_t pixel = 0; pixel < labels.num_pixels(); ++pixel) {
    const uint16_t label = labels.data()[pixel];
    float* energies = unary.data() + pixel * num_labels;
    if (label == kUnknownLabel) {
      std::fill_n(energies, num_labels, unknown);
      continue;
    }
    if (label >= num_labels) {
      return InvalidArgumentError("label " + std::to_string(label) +
                                  " is not one of " +
                                  std::to_string(num_labels));
    }
    std::fill_n(energies, num_labels, wrong);
    energies[label] = right;
  }
  return unary;
}

}  // namespace freegs::semantics
