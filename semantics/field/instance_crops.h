// SPDX-License-Identifier: BSD-3-Clause
// Instances cut out of photographs, for an encoder that sees squares (FreeGS,
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
  ImageU8 alone;     // The same with all that is not the instance in grey.
};

// The square around the pixels of `label` in `labels` (W x H), `margin` times
// its longer side wider on each side; grey where it leaves the photograph,
// W x H x 3. Nothing when no pixel has the label.
std::optional<InstanceCrop> CropInstance(const ImageU8& photo,
                                         const Image<int32_t>& labels,
                                         int32_t label,
                                         double margin);

// How much of a label a view shows.
struct LabelSight {
  size_t view = 0;
  int64_t pixels = 0;
  bool cut = false;  // It touches the border of the image.
};

// Of labels 0 .. num_labels - 1 in one view's label image: entries of `sights`
// (one list per label) for those of at least min_pixels.
void CollectSights(size_t view,
                   const Image<int32_t>& labels,
                   int64_t min_pixels,
                   std::span<std::vector<LabelSight>> sights);

// The `count` best of them: many pixels, where a label that the border cuts
// counts half. Descending; ties to the earlier view.
std::vector<LabelSight> BestSights(std::vector<LabelSight> sights,
                                   size_t count);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_INSTANCE_CROPS_H_
