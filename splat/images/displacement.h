// SPDX-License-Identifier: BSD-3-Clause
// How far what a picture shows lies beside where another shows it. A photograph
// whose pose is wrong lies beside the rendering from that pose.

#ifndef FREEGS_SPLAT_IMAGES_DISPLACEMENT_H_
#define FREEGS_SPLAT_IMAGES_DISPLACEMENT_H_

#include "core/image.h"

namespace freegs::splat {

// Returns the length in pixels of the shift that takes one picture to the
// other, by phase correlation of their grey versions under a Hann window. It
// does not depend on brightness, nor on how sharp the pictures are. Pictures
// with little in common give any length. Both have 3 channels and the same
// size; a picture without structure gives 0. Pixels that the mask ignores
// (ignored_pixels.h; null: none) count as plain grey in both.
// Source: Kuglin and Hines, "The phase correlation image alignment method",
// IEEE Conference on Cybernetics and Society 1975.
double Displacement(const ImageF& a,
                    const ImageF& b,
                    const ImageU8* mask = nullptr);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_IMAGES_DISPLACEMENT_H_
