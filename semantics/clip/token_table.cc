// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/token_table.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include <Eigen/Core>

#include "core/io/files.h"

namespace freegs::semantics {
namespace {

static_assert(std::endian::native == std::endian::little,
              "numbers are copied to little-endian files as they are");

constexpr std::string_view kMagic = "FREEGSTT";
constexpr uint32_t kVersion = 1;
constexpr size_t kHeaderSize = 8 + 4 * 4;
constexpr uint32_t kMaxRows = 1 << 24;
constexpr uint32_t kMaxColumns = 1 << 16;

template <typename T>
T Take(std::string_view content, size_t offset) {
  T value;
  std::memcpy(&value, content.data() + offset, sizeof(T));
  return value;
}

}  // namespace

StatusOr<TokenTable> TokenTable::Parse(std::string content) {
  if (content.size() < kHeaderSize || !content.starts_with(kMagic)) {
    return BadInputError("this is not a table of token vectors");
  }
  const auto version = Take<uint32_t>(content, 8);
  if (version != kVersion) {
    return BadInputError("version " + std::to_string(version) +
                         " of the file is not known; a newer program wrote it");
  }
  const auto type = Take<uint32_t>(content, 12);
  const auto rows = Take<uint32_t>(content, 16);
  const auto columns = Take<uint32_t>(content, 20);
  if (type > 1) {
    return BadInputError("element type " + std::to_string(type) +
                         " is not known");
  }
  TokenTable table;
  table.type_ = static_cast<ElementType>(type);
  if (rows == 0 || rows > kMaxRows || columns == 0 || columns > kMaxColumns ||
      content.size() - kHeaderSize !=
          uint64_t{rows} * columns * table.ElementSize()) {
    return BadInputError("the file is truncated or its header is damaged");
  }
  table.rows_ = static_cast<int>(rows);
  table.columns_ = static_cast<int>(columns);
  table.content_ = std::move(content);
  std::vector<float> row(columns);
  for (int i = 0; i < table.rows_; ++i) {
    table.CopyRow(i, row);
    for (const float value : row) {
      if (!std::isfinite(value)) {
        return BadInputError("the vector of token " + std::to_string(i) +
                             " is not finite");
      }
    }
  }
  return table;
}

StatusOr<TokenTable> TokenTable::Load(const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(std::string content, ReadFile(path));
  StatusOr<TokenTable> table = Parse(std::move(content));
  if (!table.ok()) return table.status().Annotated(path.string());
  return table;
}

void TokenTable::CopyRow(int token, std::span<float> out) const {
  const auto columns = static_cast<size_t>(columns_);
  const char* row = content_.data() + kHeaderSize +
                    static_cast<size_t>(token) * columns * ElementSize();
  if (type_ == ElementType::kFloat32) {
    std::memcpy(out.data(), row, columns * sizeof(float));
    return;
  }
  for (size_t k = 0; k < columns; ++k) {
    Eigen::half value;
    std::memcpy(&value, row + 2 * k, 2);
    out[k] = static_cast<float>(value);
  }
}

}  // namespace freegs::semantics
