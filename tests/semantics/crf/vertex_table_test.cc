// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/crf/vertex_table.h"

#include <array>
#include <map>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::semantics {
namespace {

TEST(VertexTableTest, NumbersByFirstInsertion) {
  VertexTable table(2);
  const int32_t keys[][2] = {{3, -4}, {-4, 3}, {3, -4}, {0, 0}, {-4, 3}};
  const uint32_t numbers[] = {0, 1, 0, 2, 1};
  for (int k = 0; k < 5; ++k) {
    EXPECT_EQ(table.FindOrInsert(keys[k]), numbers[k]);
  }
  EXPECT_EQ(table.size(), 3u);
  EXPECT_EQ(table.Key(1)[0], -4);
  EXPECT_EQ(table.Key(1)[1], 3);
  const int32_t other[2] = {3, 3};
  EXPECT_EQ(table.Find(other), VertexTable::kMissing);
  table.Clear();
  EXPECT_EQ(table.size(), 0u);
  EXPECT_EQ(table.Find(keys[0]), VertexTable::kMissing);
  EXPECT_EQ(table.FindOrInsert(keys[3]), 0u);
}

TEST(VertexTableTest, AgreesWithAMapWhileItGrows) {
  VertexTable table(3);
  std::map<std::array<int32_t, 3>, uint32_t> reference;
  for (int k = 0; k < 30000; ++k) {
    std::array<int32_t, 3> key;
    for (int i = 0; i < 3; ++i) {
      key[i] = static_cast<int32_t>(RandomIndex(1, i, k, 30)) - 15;
    }
    const auto next = static_cast<uint32_t>(reference.size());
    EXPECT_EQ(table.FindOrInsert(key.data()),
              reference.try_emplace(key, next).first->second);
  }
  EXPECT_EQ(table.size(), reference.size());
  for (const auto& [key, number] : reference) {
    EXPECT_EQ(table.Find(key.data()), number);
  }
}

}  // namespace
}  // namespace freegs::semantics
