// SPDX-License-Identifier: BSD-3-Clause
// The bytes of a table of token vectors, as scripts/export_clip.py writes them.

#ifndef FREEGS_TESTS_SEMANTICS_CLIP_TOKEN_TABLE_FILE_H_
#define FREEGS_TESTS_SEMANTICS_CLIP_TOKEN_TABLE_FILE_H_

#include <cstdint>
#include <span>
#include <string>

#include <Eigen/Core>

namespace freegs::semantics {

enum class TokenNumbers : uint32_t { kFloat32 = 0, kFloat16 = 1 };

// values: rows x columns. Numbers that float16 cannot hold become infinite.
inline std::string TokenTableFile(std::span<const float> values,
                                  uint32_t rows,
                                  uint32_t columns,
                                  TokenNumbers numbers) {
  std::string content = "FREEGSTT";
  const auto append = [&content](auto value) {
    content.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  append(uint32_t{1});
  append(numbers);
  append(rows);
  append(columns);
  for (const float value : values) {
    if (numbers == TokenNumbers::kFloat32) {
      append(value);
    } else {
      append(static_cast<Eigen::half>(value));
    }
  }
  return content;
}

}  // namespace freegs::semantics

#endif  // FREEGS_TESTS_SEMANTICS_CLIP_TOKEN_TABLE_FILE_H_
