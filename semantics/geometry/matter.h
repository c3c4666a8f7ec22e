// SPDX-License-Identifier: BSD-3-Clause
// Tells the Gaussians that are matter from haze and backdrop.

#ifndef FREEGS_SEMANTICS_GEOMETRY_MATTER_H_
#define FREEGS_SEMANTICS_GEOMETRY_MATTER_H_

#include <cstdint>
#include <vector>

#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

// M Gaussians of a model.
struct Matter {
  std::vector<uint32_t> rows;    // M; ascending indices of Gaussians.
  std::vector<float> positions;  // M x 3, in the model frame.
  std::vector<float> colors;     // M x 3, the part of the colour that does not
                                 // depend on the view; RGB in [0, 1].
};

// Returns the Gaussians of at least this opacity whose second largest standard
// deviation is at most max_scale (in units of the model frame,
// splat/scene/model_frame.h) and whose centre lies where a KdTree can hold it.
Matter SelectMatter(const splat::GaussianModel& model,
                    double min_opacity,
                    double max_scale);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_GEOMETRY_MATTER_H_
