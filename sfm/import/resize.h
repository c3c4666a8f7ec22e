// SPDX-License-Identifier: BSD-3-Clause
// Whether one image size comes from another one by a change of scale.

#ifndef FREEGS_SFM_IMPORT_RESIZE_H_
#define FREEGS_SFM_IMPORT_RESIZE_H_

#include <algorithm>
#include <cmath>

namespace freegs::sfm {

// Whether two sizes, in pixels, can be those of one picture that was resized,
// so that each side is off by less than a pixel. An image that was cropped by
// more than that is none.
inline bool IsResized(double width,
                      double height,
                      double new_width,
                      double new_height) {
  const double difference = std::abs(width * new_height - new_width * height);
  return difference <= std::max({width, height, new_width, new_height});
}

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_IMPORT_RESIZE_H_
