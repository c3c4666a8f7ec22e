// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/token_table.h"

#include <array>
#include <cstring>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/semantics/clip/token_table_file.h"

namespace freegs::semantics {
namespace {

using testing::ElementsAre;
using Type = TokenNumbers;

const std::vector<float> kValues = {0.5f, -1, 2, 3, 0.25f, 0};

TEST(TokenTableTest, ComesBackAsWritten) {
  for (const Type type : {Type::kFloat32, Type::kFloat16}) {
    const auto table = TokenTable::Parse(TokenTableFile(kValues, 3, 2, type));
    ASSERT_TRUE(table.ok()) << table.status().message();
    EXPECT_EQ(table->rows(), 3);
    EXPECT_EQ(table->columns(), 2);
    std::array<float, 2> row;
    table->CopyRow(2, row);
    EXPECT_THAT(row, ElementsAre(0.25f, 0));
    table->CopyRow(0, row);
    EXPECT_THAT(row, ElementsAre(0.5f, -1));
  }
}

TEST(TokenTableTest, RefusesEveryTruncationAndExtension) {
  for (const Type type : {Type::kFloat32, Type::kFloat16}) {
    const std::string content = TokenTableFile(kValues, 3, 2, type);
    for (size_t size = 0; size < content.size(); ++size) {
      EXPECT_EQ(TokenTable::Parse(content.substr(0, size)).status().code(),
                StatusCode::kBadInput);
    }
    EXPECT_FALSE(TokenTable::Parse(content + "x").ok());
  }
}

TEST(TokenTableTest, RefusesLyingHeaders) {
  const std::string content = TokenTableFile(kValues, 3, 2, Type::kFloat32);
  for (const size_t offset : {0, 8, 12, 16, 20}) {
    for (const uint32_t value :
         {0u, 7u, 0x10000u, 0x7fffffffu, 0x80000000u, 0xffffffffu}) {
      if (offset == 12 && value == 0) continue;  // It is float32.
      std::string damaged = content;
      std::memcpy(damaged.data() + offset, &value, 4);
      EXPECT_FALSE(TokenTable::Parse(damaged).ok()) << offset << " " << value;
    }
  }
  // Sizes whose product overflows to the right number of bytes.
  std::string damaged = TokenTableFile({}, 0, 0, Type::kFloat32);
  for (const size_t offset : {16, 20}) {
    const uint32_t value = 1u << 31;
    std::memcpy(damaged.data() + offset, &value, 4);
  }
  EXPECT_FALSE(TokenTable::Parse(damaged).ok());
}

TEST(TokenTableTest, RefusesWhatIsNotFinite) {
  std::vector<float> values = kValues;
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity()}) {
    values[3] = bad;
    for (const Type type : {Type::kFloat32, Type::kFloat16}) {
      const auto table = TokenTable::Parse(TokenTableFile(values, 3, 2, type));
      EXPECT_THAT(table.status().message(), testing::HasSubstr("token 1"));
    }
  }
  values[3] = 1e6f;  // Too large for 16 bits.
  EXPECT_FALSE(
      TokenTable::Parse(TokenTableFile(values, 3, 2, Type::kFloat16)).ok());
}

TEST(TokenTableTest, MissingFileIsNamed) {
  const auto table = TokenTable::Load("/no/such/table");
  EXPECT_EQ(table.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(table.status().message(), testing::HasSubstr("/no/such/table"));
}

}  // namespace
}  // namespace freegs::semantics
