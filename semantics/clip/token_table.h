// SPDX-License-Identifier: BSD-3-Clause
// The vectors that the text encoder starts from, one per token of the
// vocabulary. They are a file of their own because OpenCV's networks cannot
// look them up.

#ifndef FREEGS_SEMANTICS_CLIP_TOKEN_TABLE_H_
#define FREEGS_SEMANTICS_CLIP_TOKEN_TABLE_H_

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"

namespace freegs::semantics {

// The file text_embedding of a model folder, little-endian:
//   8 bytes   "FREEGSTT"
//   uint32    version, 1
//   uint32    element type: 0 = float32, 1 = float16 (IEEE 754)
//   uint32    rows, the size of the vocabulary
//   uint32    columns, the width of the text encoder
//   elements  rows x columns, row-major
class TokenTable {
 public:
  // kBadInput, which names the fault, for anything but a complete file of a
  // known version, and for elements that are not finite. Keeps the content of
  // the file.
  static StatusOr<TokenTable> Parse(std::string content);
  static StatusOr<TokenTable> Load(const std::filesystem::path& path);

  int rows() const { return rows_; }
  int columns() const { return columns_; }

  // Copies row `token`, which lies in [0, rows()), to `out`, which holds
  // columns() numbers.
  void CopyRow(int token, std::span<float> out) const;

 private:
  enum class ElementType : uint32_t { kFloat32 = 0, kFloat16 = 1 };

  TokenTable() = default;

  size_t ElementSize() const { return type_ == ElementType::kFloat16 ? 2 : 4; }

  std::string content_;
  ElementType type_ = ElementType::kFloat32;
  int rows_ = 0;
  int columns_ = 0;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_TOKEN_TABLE_H_
