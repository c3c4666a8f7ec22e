// SPDX-License-Identifier: BSD-3-Clause
// The trees that other weights of the evidence lead to. What is learnt is never
// exact, and the reconstruction has noise of its own: either may join two
// regions a little sooner or later, and the tree differs. A region is to be
// trusted that most trees have, and that they find good.

#ifndef FREEGS_SEMANTICS_PATCHES_TREE_VARIANTS_H_
#define FREEGS_SEMANTICS_PATCHES_TREE_VARIANTS_H_

#include <cstdint>
#include <span>
#include <vector>

#include "semantics/patches/evidence_model.h"
#include "semantics/patches/region_merging.h"
#include "semantics/patches/shared_pixels.h"

namespace freegs::semantics {

// More of them take more time and were no better (docs/instances.md).
inline constexpr int kNumTreeVariants = 8;

// Variant 0 is the model as it is. In each of the others every weight is
// multiplied by a number of its own between 0.3 and 1.7. variant: from 0 to
// kNumTreeVariants - 1.
EvidenceModel VariantOf(const EvidenceModel& model, int variant);

// Returns for each region of `tree` the quality of the region of `other` that
// is most like it, times their intersection over union in `shared` pixels. The
// trees may be of two divisions into patches: shared[i].a is a leaf of `tree`,
// shared[i].b one of `other`, sorted as FindSharedPixels returns them.
// other_quality has a number for each region of `other`. Regions that are not
// large (one flag for each, such as that a region is no crumb) get 0, and are
// not looked at in `other`; a region with a large part is large.
std::vector<double> QualityInOther(const RegionTree& tree,
                                   std::span<const uint8_t> is_large,
                                   const RegionTree& other,
                                   std::span<const uint8_t> other_is_large,
                                   std::span<const double> other_quality,
                                   std::span<const SharedPixels> shared);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_TREE_VARIANTS_H_
