// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/query_body.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base64.h"
#include "core/image.h"
#include "core/io/image_io.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

using testing::HasSubstr;

StatusOr<QueryRequest> Parse(const std::string& body) {
  QueryRequest defaults;
  defaults.text_options.min_relevancy = 0.25;
  FREEGS_ASSIGN_OR_RETURN(PageQuestion question,
                          ParseQueryBody(body, defaults));
  FREEGS_RETURN_IF_ERROR(DecodePicture(&question));
  return question.request;
}

TEST(QueryBody, ReadsEachKindOfQuestion) {
  const auto text =
      Parse(R"({"text": "red \u00e4pple", "max_hits": 3, "background": true})");
  ASSERT_TRUE(text.ok()) << text.status().message();
  EXPECT_EQ(text->text, "red \xc3\xa4pple");
  EXPECT_EQ(text->max_hits, 3);
  EXPECT_TRUE(text->text_options.background);
  EXPECT_EQ(text->text_options.min_relevancy, 0.25);

  const auto click = Parse(
      R"({"click": {"view": "a/b.jpg", "x": 1.5, "y": -2, "level": -1}})");
  ASSERT_TRUE(click.ok()) << click.status().message();
  EXPECT_EQ(click->click->view, "a/b.jpg");
  EXPECT_EQ(click->click->numbers, (std::vector<double>{1.5, -2}));
  EXPECT_EQ(click->level, -1);
  EXPECT_EQ(click->max_hits, 1);
  const auto plain = Parse(R"({"click": {"view": "a", "x": 1, "y": 2,
                               "level": 0}})");
  ASSERT_TRUE(plain.ok());
  EXPECT_FALSE(plain->level);

  const TemporaryFolder folder;
  ASSERT_TRUE(WriteImage(folder / "a.png", ImageU8(5, 4, 3, 200)).ok());
  const auto example = Parse(R"({"example": ")" +
                             EncodeBase64(ReadText(folder / "a.png")) + "\"}");
  ASSERT_TRUE(example.ok()) << example.status().message();
  EXPECT_TRUE(example->example);
  EXPECT_EQ(example->example_pixels.width(), 5);
}

TEST(QueryBody, NamesWhatIsWrong) {
  const auto why = [](const std::string& body) {
    const auto request = Parse(body);
    EXPECT_EQ(request.status().code(), StatusCode::kInvalidArgument) << body;
    return request.status().message();
  };
  EXPECT_THAT(why(""), HasSubstr("JSON"));
  EXPECT_THAT(why("[]"), HasSubstr("object"));
  EXPECT_THAT(why("{}"), HasSubstr("one question"));
  EXPECT_THAT(why(R"({"text": "a", "click": {"view": "a", "x": 1, "y": 1}})"),
              HasSubstr("one question"));
  EXPECT_THAT(why(R"({"text": 3})"), HasSubstr("text"));
  EXPECT_THAT(why(R"({"text": " \t"})"), HasSubstr("no words"));
  EXPECT_THAT(why(R"({"text": ")" + std::string(2000, 'a') + "\"}"),
              HasSubstr("longer"));
  EXPECT_THAT(why(R"({"text": "a", "max_hits": -1})"), HasSubstr("max_hits"));
  EXPECT_THAT(why(R"({"text": "a", "background": 1})"),
              HasSubstr("background"));
  EXPECT_THAT(why(R"({"text": "a", "out": "/tmp"})"), HasSubstr("out"));
  EXPECT_THAT(why(R"({"click": []})"), HasSubstr("click"));
  EXPECT_THAT(why(R"({"click": {"view": "a", "x": 1e300, "y": 1}})"),
              HasSubstr("click.x"));
  EXPECT_THAT(why(R"({"click": {"view": "a", "x": 1, "y": 1, "level": 1e9}})"),
              HasSubstr("click.level"));
  EXPECT_THAT(why(R"({"click": {"view": "a", "x": 1, "y": 1, "wider": 3}})"),
              HasSubstr("click.wider"));
  EXPECT_THAT(why(R"({"example": "a*b="})"), HasSubstr("base64"));
  EXPECT_THAT(why(R"({"example": "aGVsbG8="})"), HasSubstr("JPEG"));
  // A PNG that ends after its first bytes.
  EXPECT_THAT(why(R"({"example": "iVBORw0KGgo="})"), HasSubstr("example"));
}

}  // namespace
}  // namespace freegs::stages
