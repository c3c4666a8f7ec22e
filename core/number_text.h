// SPDX-License-Identifier: BSD-3-Clause
// Writes numbers as a person reads them.

#ifndef FREEGS_CORE_NUMBER_TEXT_H_
#define FREEGS_CORE_NUMBER_TEXT_H_

#include <cstdint>
#include <string>

namespace freegs {

// The value with this many digits after the point, or "–" when it is not
// finite.
std::string FormatFixed(double value, int decimals);

// How many digits after the point show a value and a limit: this many, or up to
// three more where both would look the same, as 0.4997 and 0.5 do with three.
int DecimalsApart(double value, double limit, int decimals);

// How many digits after the point show a value of this size to three digits: 2
// for 1.5, 5 for 0.0015, at least 0 and at most 12; 3 for 0 and for what is no
// length.
int DecimalsFor(double length);

// The number with at most this many significant digits, without trailing zeros:
// 0.0034567 with 3 digits is "0.00346", 1e12 is "1e+12". "–" when the value is
// not finite.
std::string FormatSignificant(double value, int digits);

// A share of 1 in whole percent: 0.834 is "83 %". "–" when it is not finite.
std::string FormatPercent(double share);

// 48211 is "48,211".
std::string FormatCount(int64_t count);

// "1.4 s", "45 s", "3 min 05 s", "1 h 02 min", "over 30 years"; "–" when the
// duration is negative or not finite.
std::string FormatSeconds(double seconds);

// What is called GB everywhere in this program: 10^9 bytes.
inline constexpr int64_t kGigabyte = 1'000'000'000;

// "812 B", "1.4 MB", in powers of 1000; "–" when the size is negative or not
// finite.
std::string FormatBytes(double bytes);

}  // namespace freegs

#endif  // FREEGS_CORE_NUMBER_TEXT_H_
