// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/geometry/matter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/kd_tree.h"

namespace freegs::semantics {

Matter SelectMatter(const splat::GaussianModel& model,
                    double min_opacity,
                    double max_scale) {
  Matter matter;
  for (uint32_t i = 0; i < model.size(); ++i) {
    const float* mean = model.means.data() + i * size_t{3};
    const double opacity = splat::Opacity(model, i);
    std::array<float, 3> scales;
    std::copy_n(model.log_scales.data() + i * size_t{3}, 3, scales.begin());
    std::nth_element(scales.begin(), scales.begin() + 1, scales.end());
    const float* color = model.sh_dc.data() + i * size_t{3};
    const bool finite =
        std::all_of(
            mean,
            mean + 3,
            [](float x) { return std::abs(x) <= KdTree::kMaxCoordinate; }) &&
        std::all_of(color, color + 3, [](float c) { return std::isfinite(c); });
    if (!finite || !(opacity >= min_opacity) ||
        !(std::exp(scales[1]) <= max_scale)) {
      continue;
    }
    matter.rows.push_back(i);
    for (size_t k = 0; k < 3; ++k) {
      matter.positions.push_back(mean[k]);
      matter.colors.push_back(
          std::clamp(splat::kShC0 * color[k] + 0.5f, 0.0f, 1.0f));
    }
  }
  return matter;
}

}  // namespace freegs::semantics
