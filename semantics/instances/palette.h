// SPDX-License-Identifier: BSD-3-Clause
// Colours for labels.

#ifndef FREEGS_SEMANTICS_INSTANCES_PALETTE_H_
#define FREEGS_SEMANTICS_INSTANCES_PALETTE_H_

#include <array>
#include <cstdint>

namespace freegs::semantics {

// 8-bit RGB. Successive labels differ strongly: hues advance by the golden
// angle, brightness and saturation change every few labels. Dark grey for
// negative labels. A fixed function: the same label has the same colour in
// every view and file.
std::array<uint8_t, 3> PaletteColor(int32_t label);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_PALETTE_H_
