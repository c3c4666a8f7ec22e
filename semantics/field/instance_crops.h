// SPDX-License-Identifier: BSD-3-Clause
// Cuts instances out of photographs, for an encoder that sees squares (FreeGS,
// "Instance-level Feature Distillation").

#ifndef FREEGS_SEMANTICS_FIELD_INSTANCE_CROPS_H_
#define FREEGS_SEMANTICS_FIELD_INSTANCE_CROPS_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/image.h"

namespace freegs::semantics {

struct InstanceCrop {
  ImageU8 in_place;  // A square of the photograph around the instance.
  ImageU8 alone;     // This square, but grey outside of the instance.
};

// Cuts out the square around the pixels of `label` in `labels` (W x H). On each
// side it is wider by `margin` times the longer side of the instance. It is
// grey where it leaves the photograph, W x H x 3. Nothing if no pixel has the
// label.
std::optional<InstanceCrop> CropInstance(const ImageU8& photo,
                                         const Image<int32_t>& labels,
                                         int32_t label,
                                         double margin);

// How much of a label a view shows.
struct LabelSight {
  size_t view = 0;
  int64_t pixels = 0;
  bool cut = false;  // The label touches the border of the image.
};

// What the label image of a view shows of each label 0 .. num_labels - 1.
std::vector<LabelSight> SightsOf(size_t view,
                                 const Image<int32_t>& labels,
                                 int num_labels);

// Returns the `count` best sights, the best first. A sight is better if it has
// more pixels; the pixels of a label that the border cuts count half. Among
// equals the earlier one comes first.
std::vector<LabelSight> BestSights(std::vector<LabelSight> sights,
                                   size_t count);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_INSTANCE_CROPS_H_
