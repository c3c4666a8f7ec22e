// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/matching/photo_overlap.h"

#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/sfm/match_database_writer.h"
#include "tests/temporary_folder.h"

namespace freegs::sfm {
namespace {

std::vector<uint32_t> SomeMatches(uint32_t count) {
  return std::vector<uint32_t>(2 * size_t{count}, 0);
}

TEST(PhotoOverlap, MatchesWithTheThirdBestPartner) {
  const TemporaryFolder folder;
  const auto path = folder / "a.db";
  {
    MatchDatabaseWriter writer(path);
    for (int64_t id = 1; id <= 5; ++id) {
      writer.AddPhoto(id, std::to_string(id) + ".jpg", {1, 2});
    }
    // The third best of photos 1 to 4 are 7, 20, 30 and 20; 5 has one partner.
    writer.Add(1, 2, SomeMatches(90));
    writer.Add(1, 3, SomeMatches(80));
    writer.Add(1, 4, SomeMatches(7));
    writer.Add(2, 3, SomeMatches(30));
    writer.Add(2, 4, SomeMatches(20));
    writer.Add(3, 4, SomeMatches(60));
    writer.Add(4, 5, SomeMatches(50));
  }
  const auto database = MatchDatabase::Open(path);
  ASSERT_TRUE(database.ok()) << database.status().message();
  // Of 0, 7, 20, 20 and 30.
  EXPECT_EQ(MatchesOfThirdPartner(*database).value(), 7);
}

TEST(PhotoOverlap, WithoutMatches) {
  const TemporaryFolder folder;
  const auto path = folder / "a.db";
  { MatchDatabaseWriter writer(path); }
  const auto database = MatchDatabase::Open(path);
  ASSERT_TRUE(database.ok()) << database.status().message();
  EXPECT_EQ(MatchesOfThirdPartner(*database).value(), 0);
}

}  // namespace
}  // namespace freegs::sfm
