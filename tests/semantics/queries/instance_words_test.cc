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

TEST(InstanceWordsTest, TheBestWordOfEachGroupThatFits) {
  ColorEncoder encoder;
  const auto names = NameInstances(Vectors({{0.7, 0.1, 0.1}, {0.1, 0.3, 0.9}}),
                                   {{"red", "blue"}, {"thing"}, {"blue"}},
                                   encoder);
  ASSERT_TRUE(names.ok());
  ASSERT_EQ(names->size(), 2u);
  // "thing" is as grey as all phrases.
  EXPECT_EQ((*names)[0], (Words{"red blue", "red", "blue"}));
  EXPECT_EQ((*names)[1], (Words{"blue blue", "blue", "blue"}));
}

TEST(InstanceWordsTest, NothingIsKnownOfAZeroVector) {
  ColorEncoder encoder;
  const auto names =
      NameInstances(std::vector<float>(8, 0.0f), {{"red"}}, encoder);
  ASSERT_TRUE(names.ok());
  ASSERT_EQ(names->size(), 1u);
  EXPECT_TRUE((*names)[0].empty());
}

TEST(InstanceWordsTest, WithoutVocabularyThereAreNoWords) {
  ColorEncoder encoder;
  const auto names = NameInstances(Vectors({{1, 0, 0}}), {}, encoder);
  ASSERT_TRUE(names.ok());
  EXPECT_TRUE((*names)[0].empty());
}

}  // namespace
}  // namespace freegs::semantics
