// SPDX-License-Identifier: BSD-3-Clause
// How strong the boundary between two neighbouring pixels of a photograph is.

#ifndef FREEGS_SEMANTICS_PATCHES_LOCAL_CONTRAST_H_
#define FREEGS_SEMANTICS_PATCHES_LOCAL_CONTRAST_H_

#include <cstddef>

#include "core/image.h"
#include "semantics/patches/sum_table.h"

namespace freegs::semantics {

// RGB in [0, 1] to CIE L*a*b* divided by 100.
ImageF ToLab(const ImageF& rgb);

// Compares the windows on both sides of a boundary, which are `reach` pixels
// deep. Sums over windows come from tables (integral images), so that any size
// costs the same.
class LocalContrast {
 public:
  // lab: see ToLab.
  explicit LocalContrast(const ImageF& lab);

  struct Step {
    // In [0, 1]: the squared difference of the mean colours, as a share of
    // itself and of the variances within the windows (a Fisher criterion).
    // Texture has a large variance and so a small contrast.
    double contrast = 0;
    // The difference of the mean colours; 1 is from black to white.
    double difference = 0;
  };

  // The boundary between pixel (x, y) and its neighbour to the right or, if
  // not `horizontal`, below it. It may lie one pixel beside its place in the
  // photograph: the strongest of three is returned.
  Step Across(int x, int y, bool horizontal, int reach) const;

 private:
  static constexpr size_t kSums = 6;  // Three channels and their squares.

  SumTable<kSums> table_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_LOCAL_CONTRAST_H_
