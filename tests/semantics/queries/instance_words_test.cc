// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/queries/instance_words.h"

#include <gtest/gtest.h>

#include "tests/semantics/clip/color_encoder.h"

namespace freegs::semantics {
namespace {

using Words = std::vector<std::string>;

std::vector<float> Vectors(const std::vector<std::array<double, 3>>& colors) {
  std::vector<float> vectors;
  for (const auto& color : colors) {
    const std::vector<float> vector = ColorEncoder::Embed(color);
    vectors.insert(vectors.end(), vector.begin(), vector.end());
  }
  return vectors;
}

StatusOr<InstanceNames> Name(const std::vector<float>& vectors,
                             const std::vector<Words>& groups,
                             double min_confidence) {
  ColorEncoder encoder;
  FREEGS_ASSIGN_OR_RETURN(const Vocabulary vocabulary,
                          Vocabulary::Create(groups, encoder));
  return NameInstances(
      vectors, encoder.embedding_dim(), vocabulary, min_confidence);
}

TEST(InstanceWordsTest, TheBestWordOfEachGroupThatFits) {
  const auto names = Name(Vectors({{0.7, 0.1, 0.1}, {0.1, 0.3, 0.9}}),
                          {{"red", "blue"}, {"thing"}, {"blue"}},
                          0);
  ASSERT_TRUE(names.ok());
  ASSERT_EQ(names->words.size(), 2u);
  // "thing" is as grey as all phrases.
  EXPECT_EQ(names->words[0], (Words{"red blue", "red", "blue"}));
  EXPECT_EQ(names->words[1], (Words{"blue blue", "blue", "blue"}));
  EXPECT_EQ(names->num_withheld, 0);
}

TEST(InstanceWordsTest, WordsThatAreNotCertainAreWithheld) {
  const std::vector<float> vectors =
      Vectors({{0.8, 0.1, 0.1}, {0.7, 0.4, 0.4}});
  const auto count = [&](double min_confidence) {
    const auto names = Name(vectors, {{"red", "blue"}}, min_confidence);
    EXPECT_TRUE(names.ok());
    EXPECT_EQ(names->words.size(), 2u);
    return names->num_withheld;
  };
  const auto all = Name(vectors, {{"red", "blue"}}, 0);
  ASSERT_TRUE(all.ok());
  EXPECT_EQ(all->words, (std::vector<Words>{{"red"}, {"red"}}));
  EXPECT_EQ(count(0.501), 0);
  const auto some = Name(vectors, {{"red", "blue"}}, 0.97);
  ASSERT_TRUE(some.ok());
  EXPECT_EQ(some->words, (std::vector<Words>{{"red"}, {}}));
  EXPECT_EQ(some->num_withheld, 1);
  EXPECT_EQ(count(1), 2);
}

TEST(InstanceWordsTest, TheLastGroupIsThatOfThings) {
  const std::vector<float> vectors = Vectors({{0.8, 0.1, 0.1}});
  const auto names = Name(vectors, {{"red"}, {"thing"}}, 0.6);
  ASSERT_TRUE(names.ok());
  EXPECT_TRUE(names->words[0].empty()) << "Red, but what is it?";
  EXPECT_EQ(names->num_withheld, 1);
}

TEST(InstanceWordsTest, NothingIsKnownOfAZeroVector) {
  const auto names = Name(std::vector<float>(8, 0.0f), {{"red"}}, 0.5);
  ASSERT_TRUE(names.ok());
  ASSERT_EQ(names->words.size(), 1u);
  EXPECT_TRUE(names->words[0].empty());
  EXPECT_EQ(names->num_withheld, 0);
}

TEST(InstanceWordsTest, WithoutVocabularyThereAreNoWords) {
  const auto names = Name(Vectors({{1, 0, 0}}), {}, 0.5);
  ASSERT_TRUE(names.ok());
  EXPECT_TRUE(names->words[0].empty());
  EXPECT_EQ(names->num_withheld, 0);
}

}  // namespace
}  // namespace freegs::semantics
