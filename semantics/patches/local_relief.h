// SPDX-License-Identifier: BSD-3-Clause
// How far apart in depth the surfaces on both sides of a boundary between two
// neighbouring pixels are.

#ifndef FREEGS_SEMANTICS_PATCHES_LOCAL_RELIEF_H_
#define FREEGS_SEMANTICS_PATCHES_LOCAL_RELIEF_H_

#include <cstddef>

#include "core/image.h"
#include "semantics/patches/sum_table.h"

namespace freegs::semantics {

// Fits a plane to the windows on both sides of a boundary, which are `reach`
// pixels deep. The inverse depth of a plane is linear in the image, so a fit is
// a linear regression, and its sums come from tables (integral images).
class LocalRelief {
 public:
  // inverse_depth: one channel, 0 where nothing is known. noise: a standard
  // deviation of inverse depths that says nothing.
  LocalRelief(const ImageF& inverse_depth, double noise);

  // The boundary between pixel (x, y) and its neighbour to the right or, if not
  // `horizontal`, below it. In [0, 1]: the squared step between the two planes
  // at the boundary, as a share of itself and of the variances around the
  // planes. Rough surfaces have a large variance and so a small step. 0 where
  // too little is known on one side.
  double Step(int x, int y, bool horizontal, int reach) const;

 private:
  // Number, x, y, d, x x, x y, y y, x d, y d, d d.
  static constexpr size_t kSums = 10;

  SumTable<kSums> table_;
  double noise_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_LOCAL_RELIEF_H_
