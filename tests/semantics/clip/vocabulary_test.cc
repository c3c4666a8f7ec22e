// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/vocabulary.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/semantics/clip/color_encoder.h"

namespace freegs::semantics {
namespace {

TEST(VocabularyTest, TheBestWordOfAGroup) {
  ColorEncoder encoder;
  const auto vocabulary =
      Vocabulary::Create({{"red", "blue"}, {"thing"}, {"green"}}, encoder);
  ASSERT_TRUE(vocabulary.ok());
  EXPECT_EQ(vocabulary->num_groups(), 3u);
  const std::vector<float> red = ColorEncoder::Embed({0.7, 0.1, 0.1});
  const Vocabulary::Fit fit = vocabulary->BestOf(0, red);
  ASSERT_NE(fit.word, nullptr);
  EXPECT_EQ(*fit.word, "red");
  EXPECT_GT(fit.relevancy, 0.5f);
  // As grey as the canonical phrases.
  EXPECT_EQ(vocabulary->BestOf(1, red).word, nullptr);
  EXPECT_EQ(vocabulary->BestOf(0, std::vector<float>(8, 0.0f)).word, nullptr);
}

TEST(VocabularyTest, TheLastGroupIsThatOfThings) {
  ColorEncoder encoder;
  const std::vector<float> red = ColorEncoder::Embed({0.7, 0.1, 0.1});
  const auto things = Vocabulary::Create({{"green"}, {"red"}}, encoder);
  const auto colors = Vocabulary::Create({{"red"}, {"thing"}}, encoder);
  const auto none = Vocabulary::Create({}, encoder);
  ASSERT_TRUE(things.ok() && colors.ok() && none.ok());
  ASSERT_NE(things->Thing(red).word, nullptr);
  EXPECT_EQ(*things->Thing(red).word, "red");
  EXPECT_EQ(things->Thing(red).relevancy, things->BestOf(1, red).relevancy);
  EXPECT_EQ(colors->Thing(red).word, nullptr);
  EXPECT_EQ(none->num_groups(), 0u);
}

// An encoder to which no text says anything.
class DeafEncoder : public ColorEncoder {
 public:
  StatusOr<TextEmbedding> EncodeText(const std::string&) override {
    return InvalidArgumentError("there are no words in the text");
  }
};

TEST(VocabularyTest, WordsOfTheModelAreNotTheUsersFault) {
  DeafEncoder encoder;
  const Status status = Vocabulary::Create({{"mug"}}, encoder).status();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), testing::HasSubstr("model.json"));
}

}  // namespace
}  // namespace freegs::semantics
