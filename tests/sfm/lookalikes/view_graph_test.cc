// SPDX-License-Identifier: BSD-3-Clause
// Contradictions between a model and its matches.

#include "sfm/lookalikes/view_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sfm/match_database_writer.h"
#include "tests/sfm/synthetic_model.h"
#include "tests/temporary_folder.h"

namespace freegs::sfm {
namespace {

using testing::IsEmpty;
using testing::UnorderedElementsAre;
using Pair = std::pair<uint32_t, uint32_t>;

PairAgreement Agreeing(uint32_t a, uint32_t b, int64_t matches) {
  return {a, b, matches, matches * 9 / 10, matches / 20};
}
PairAgreement Contradicting(uint32_t a, uint32_t b, int64_t matches) {
  return {a, b, matches, matches / 100, matches * 6 / 10};
}

TEST(FindContradictions, NoneInAConsistentModel) {
  // 1 - 2 - 3 - 4 in a row; 1 and 4 only look alike, and the model knows.
  const Contradictions found = FindContradictions({Agreeing(1, 2, 900),
                                                   Agreeing(2, 3, 1000),
                                                   Agreeing(3, 4, 800),
                                                   Agreeing(1, 3, 300),
                                                   Contradicting(1, 4, 600)});
  EXPECT_THAT(found.strongest, IsEmpty());
  EXPECT_THAT(found.suspects, IsEmpty());
  EXPECT_THAT(FindContradictions({}).strongest, IsEmpty());
}

TEST(FindContradictions, CutsWhereTheModelIgnoresStrongMatches) {
  // 3 and 4 were put where 1 is, because 1 - 4 look alike.
  const Contradictions found = FindContradictions({Agreeing(1, 2, 900),
                                                   Contradicting(2, 3, 1000),
                                                   Agreeing(3, 4, 800),
                                                   Contradicting(2, 4, 300),
                                                   Agreeing(1, 4, 600),
                                                   Agreeing(1, 3, 100)});
  EXPECT_THAT(found.strongest, UnorderedElementsAre(Pair(2, 3)));
  EXPECT_THAT(found.suspects, UnorderedElementsAre(Pair(1, 4), Pair(1, 3)));
}

TEST(FindContradictions, FewMatchesProveNothing) {
  const Contradictions found = FindContradictions(
      {Agreeing(1, 2, 900), {2, 3, 40, 0, 29}, {3, 4, 900, 200, 700}});
  EXPECT_THAT(found.strongest, IsEmpty());
}

TEST(MeasureAgreement, CountsPointsThatFeaturesShare) {
  const Reconstruction model = SyntheticModel(3, 40);
  const TemporaryFolder folder;
  const std::string path = (folder / "a.db").string();
  {
    // Feature k shows point k in all images; 40 shows none, 999 does not exist.
    MatchDatabaseWriter database(path);
    database.Add(1, 2, {0, 0, 5, 5, 7, 8, 40, 3, 3, 999});
    database.Add(2, 3, {1, 2});
    database.Add(3, 77, {1, 2});
  }

  auto opened = MatchDatabase::Open(path);
  ASSERT_TRUE(opened.ok());
  const auto pairs = MeasureAgreement(model, *opened);
  ASSERT_TRUE(pairs.ok());
  ASSERT_EQ(pairs->size(), 2u);
  EXPECT_EQ((*pairs)[0].matches, 5);
  EXPECT_EQ((*pairs)[0].agreeing, 2);
  EXPECT_EQ((*pairs)[0].contradicting, 1);
  EXPECT_TRUE((*pairs)[0].agrees());

  EXPECT_TRUE(opened->RemoveVerifiedPairs({{2, 1}}).ok());
  EXPECT_EQ(MeasureAgreement(model, *opened)->size(), 1u);
}

}  // namespace
}  // namespace freegs::sfm
