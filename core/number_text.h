// SPDX-License-Identifier: BSD-3-Clause
// Numbers as a person reads them: fixed decimals, counts, durations, sizes.

#ifndef FREEGS_CORE_NUMBER_TEXT_H_
#define FREEGS_CORE_NUMBER_TEXT_H_

#include <cstdint>
#include <string>

namespace freegs {

// Fixed decimals; "–" when the value is not finite.
std::string FormatFixed(double value, int decimals);

// 48211 -> "48,211".
std::string FormatCount(int64_t count);

// "1.4 s", "45 s", "3 min 05 s", "1 h 02 min".
std::string FormatSeconds(double seconds);

// "812 B", "1.4 MB" (powers of 1000).
std::string FormatBytes(double bytes);

}  // namespace freegs

#endif  // FREEGS_CORE_NUMBER_TEXT_H_
