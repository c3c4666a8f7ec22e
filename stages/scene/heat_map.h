// SPDX-License-Identifier: BSD-3-Clause
// Shows one number per pixel as colours over the picture it belongs to.

#ifndef FREEGS_STAGES_SCENE_HEAT_MAP_H_
#define FREEGS_STAGES_SCENE_HEAT_MAP_H_

#include <array>
#include <cstdint>

#include "core/image.h"

namespace freegs::stages {

// The inferno scale as RGB, from dark to bright.
using ColorScale = std::array<std::array<uint8_t, 3>, 256>;
ColorScale InfernoScale();

// The picture is grey where `values` is `low` or less. Above that it takes the
// colours of the inferno scale, which reach their brightest at `high`.
// `picture` is H x W x 3 RGB and `values` is H x W x 1; low < high.
ImageU8 HeatMap(const ImageU8& picture,
                const ImageF& values,
                double low,
                double high);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_HEAT_MAP_H_
