// SPDX-License-Identifier: BSD-3-Clause
// The text that pages send pictures as.

#ifndef FREEGS_TESTS_STAGES_VIEW_BASE64_H_
#define FREEGS_TESTS_STAGES_VIEW_BASE64_H_

#include <cstdint>
#include <string>
#include <string_view>

namespace freegs::stages {

inline std::string EncodeBase64(std::string_view bytes) {
  constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t bits = 0;
    for (size_t k = i; k < i + 3; ++k) {
      bits =
          bits << 8 | (k < bytes.size() ? static_cast<uint8_t>(bytes[k]) : 0);
    }
    for (int k = 0; k < 4; ++k) text += kDigits[bits >> (18 - 6 * k) & 63];
  }
  const size_t missing = (3 - bytes.size() % 3) % 3;
  return text.replace(text.size() - missing, missing, missing, '=');
}

}  // namespace freegs::stages

#endif  // FREEGS_TESTS_STAGES_VIEW_BASE64_H_
