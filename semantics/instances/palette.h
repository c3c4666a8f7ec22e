// SPDX-License-Identifier: BSD-3-Clause
// Colours to draw labels in.

#ifndef FREEGS_SEMANTICS_INSTANCES_PALETTE_H_
#define FREEGS_SEMANTICS_INSTANCES_PALETTE_H_

#include <array>
#include <cstdint>

namespace freegs::semantics {

// Returns an 8-bit RGB colour, dark grey for negative labels. Successive labels
// differ strongly: hues advance by the golden angle, and brightness and
// saturation change every few labels. A label has the same colour in every view
// and file.
std::array<uint8_t, 3> PaletteColor(int32_t label);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_PALETTE_H_
