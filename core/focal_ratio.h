// SPDX-License-Identifier: BSD-3-Clause
// Which focal lengths a photograph can have.

#ifndef FREEGS_CORE_FOCAL_RATIO_H_
#define FREEGS_CORE_FOCAL_RATIO_H_

namespace freegs {

// The least and the largest focal length, in multiples of the longest side of
// the image. No photograph has a field of view above 150 degrees or below a
// fifth of one.
inline constexpr double kMinFocalRatio = 0.13;
inline constexpr double kMaxFocalRatio = 300;

}  // namespace freegs

#endif  // FREEGS_CORE_FOCAL_RATIO_H_
