// SPDX-License-Identifier: BSD-3-Clause
// Numbers per pixel as colours over the picture they belong to.

#ifndef FREEGS_STAGES_SCENE_HEAT_MAP_H_
#define FREEGS_STAGES_SCENE_HEAT_MAP_H_

#include "core/image.h"

namespace freegs::stages {

// The picture in grey where values (W x H x 1) are at `low` or below, turning
// to ever brighter colours of the inferno scale up to `high` and above.
// `picture` is W x H x 3; low < high.
ImageU8 HeatMap(const ImageU8& picture,
                const ImageF& values,
                double low,
                double high);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_HEAT_MAP_H_
