// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/token_table.h"

#include <cmath>
#include <cstdint>
#include <utility>

#include <Eigen/Core>

#include "core/io/byte_stream.h"
#include "core/io/files.h"

namespace freegs::semantics {
namespace {

constexpr std::string_view kTableMagic = "FREEGSTT";
constexpr uint32_t kTableVersion = 1;
constexpr size_t kHeaderSize = 8 + 4 * 4;
constexpr uint32_t kMaxRows = 1 << 24;
constexpr uint32_t kMaxColumns = 1 << 16;

}  // namespace

StatusOr<TokenTable> TokenTable::Parse(std::string content) {
  ByteReader reader(content);
  uint32_t version = 0;
  uint32_t type = 0;
  uint32_t rows = 0;
  uint32_t columns = 0;
  if (!reader.SkipBytes(kTableMagic) || !reader.Get(&version) ||
      !reader.Get(&type) || !reader.Get(&rows) || !reader.Get(&columns)) {
    return BadInputError("this is not a table of token vectors");
  }
  if (version != kTableVersion) {
    return BadInputError("version " + std::to_string(version) +
                         " of the file is not known; a newer program wrote it");
  }
  if (type > 1) {
    return BadInputError("element type " + std::to_string(type) +
                         " is not known");
  }
  TokenTable table;
  table.type_ = static_cast<ElementType>(type);
  if (rows == 0 || rows > kMaxRows || columns == 0 || columns > kMaxColumns ||
      reader.remaining() != uint64_t{rows} * columns * table.ElementSize()) {
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
  ByteReader reader(std::string_view(content_).substr(
      kHeaderSize + static_cast<size_t>(token) * columns * ElementSize()));
  if (type_ == ElementType::kFloat32) {
    reader.GetArray(columns, out.data());
    return;
  }
  for (size_t k = 0; k < columns; ++k) {
    uint16_t bits = 0;
    reader.Get(&bits);
    out[k] = static_cast<float>(Eigen::numext::bit_cast<Eigen::half>(bits));
  }
}

}  // namespace freegs::semantics
