// SPDX-License-Identifier: BSD-3-Clause
// Disturbances of the pixels of one photograph.

#ifndef FREEGS_STAGES_DISTURB_DISTURB_PIXELS_H_
#define FREEGS_STAGES_DISTURB_DISTURB_PIXELS_H_

#include <cstdint>

#include "core/image.h"
#include "stages/disturb/disturbance.h"

namespace freegs::stages {

// Which photograph it is.
struct PhotoTurn {
  double along = 0;   // Its place among all: 0 for the first, 1 for the last.
  uint64_t seed = 0;  // Seed of what is drawn for this photograph.
};

// Whether the disturbance is one of the pixels.
bool ChangesPixels(DisturbanceKind kind);

// Disturbs an RGB photograph. Drifts of light and colour are brightness times a
// factor before the sRGB curve (IEC 61966-2-1). Disturbances of another kind
// leave the photograph as it is; compression is not done here.
void DisturbPixels(const Disturbance& disturbance,
                   const PhotoTurn& turn,
                   ImageU8* photo);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_DISTURB_DISTURB_PIXELS_H_
