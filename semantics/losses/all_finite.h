// SPDX-License-Identifier: BSD-3-Clause
// Tells whether training has gone astray.

#ifndef FREEGS_SEMANTICS_LOSSES_ALL_FINITE_H_
#define FREEGS_SEMANTICS_LOSSES_ALL_FINITE_H_

#include <cmath>
#include <span>

namespace freegs::semantics {

// Whether none of the numbers is infinite or no number.
inline bool AllFinite(std::span<const float> values) {
  bool finite = true;  // No early exit, so that the loop is vectorised.
  for (const float value : values) finite &= std::isfinite(value);
  return finite;
}

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_ALL_FINITE_H_
