// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/byte_pair_tokenizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/gzip.h"
#include "core/random.h"
#include "tests/shared_data.h"
#include "tests/temporary_folder.h"

namespace freegs::semantics {
namespace {

constexpr int kContext = 77;  // CLIP's context length.

using testing::ElementsAre;
using testing::HasSubstr;

constexpr char kMerges[] =
    "header\n"
    "r e\n"       // 512
    "re d</w>\n"  // 513
    "a p\n"       // 514
    "p l\n"       // 515
    "e a\n";      // 516, too late for "rea": "re" comes first.

// Letters stand where they do in ASCII, from '!'.
constexpr int32_t Letter(char c) { return c - '!'; }
constexpr int32_t LastLetter(char c) { return 256 + c - '!'; }

BytePairTokenizer Make() { return *BytePairTokenizer::Parse(kMerges); }

std::vector<int32_t> Ids(const std::string& text) {
  return Make().Tokenize(text, kContext)->ids;
}

TEST(BytePairTokenizerTest, NumbersItsTokens) {
  const BytePairTokenizer tokenizer = Make();
  EXPECT_EQ(tokenizer.start_token(), 517);
  EXPECT_EQ(tokenizer.end_token(), 518);
  EXPECT_EQ(tokenizer.vocab_size(), 519);
}

TEST(BytePairTokenizerTest, MergesInTheOrderOfTheFile) {
  EXPECT_THAT(Ids("Red"), ElementsAre(517, 513, 518));
  EXPECT_THAT(Ids("rea"), ElementsAre(517, 512, LastLetter('a'), 518));
  EXPECT_THAT(Ids("apple"), ElementsAre(517, 514, 515, LastLetter('e'), 518));
  EXPECT_THAT(Ids("reds"),
              ElementsAre(517, 512, Letter('d'), LastLetter('s'), 518));
  EXPECT_THAT(Ids(""), ElementsAre(517, 518));
}

TEST(BytePairTokenizerTest, BytesThatAreNotPrintableComeLast) {
  // The non-printable bytes in order: 0 .. 32, 127 .. 160, 173.
  EXPECT_THAT(Ids(std::string("\x01")), ElementsAre(517, 256 + 188 + 1, 518));
  EXPECT_THAT(
      Ids("\u00e9"),  // C3 A9
      ElementsAre(517, 94 + 0xC3 - 0xA1 - 1, 256 + 94 + 0xA9 - 0xA1, 518));
}

TEST(BytePairTokenizerTest, TruncatesAndSaysSo) {
  const BytePairTokenizer tokenizer = Make();
  const auto exact = tokenizer.Tokenize("red red red", 5);
  ASSERT_TRUE(exact.ok());
  EXPECT_THAT(exact->ids, ElementsAre(517, 513, 513, 513, 518));
  EXPECT_FALSE(exact->truncated);
  const auto cut = tokenizer.Tokenize("red red red red", 5);
  ASSERT_TRUE(cut.ok());
  EXPECT_EQ(cut->ids, exact->ids);
  EXPECT_TRUE(cut->truncated);
}

TEST(BytePairTokenizerTest, HostileText) {
  const BytePairTokenizer tokenizer = Make();
  EXPECT_EQ(
      tokenizer.Tokenize(std::string(10001, 'a'), kContext).status().code(),
      StatusCode::kInvalidArgument);
  EXPECT_EQ(tokenizer.Tokenize("a", 2).status().code(),
            StatusCode::kInvalidArgument);
  EXPECT_EQ(tokenizer.Tokenize(std::string(10000, 'a'), kContext)->ids.size(),
            77u);
  for (uint64_t round = 0; round < 200; ++round) {
    std::string text;
    for (uint64_t i = 0; i < 300; ++i) {
      text.push_back(static_cast<char>(RandomBits(7, round, i)));
    }
    const auto tokens = tokenizer.Tokenize(text, kContext);
    ASSERT_TRUE(tokens.ok());
    ASSERT_LE(tokens->ids.size(), 77u);
    for (const int32_t id : tokens->ids) {
      ASSERT_GE(id, 0);
      ASSERT_LT(id, tokenizer.vocab_size());
    }
  }
}

TEST(BytePairTokenizerTest, RefusesWhatIsNotAListOfMerges) {
  for (const auto& [text, fault] :
       std::initializer_list<std::pair<std::string, std::string>>{
           {"", "no byte-pair merges"},
           {"header", "no byte-pair merges"},
           {"header\nab", "line 2 is not two pieces"},
           {"header\na b c\n", "line 2 is not two pieces"},
           {"header\na b\n\na c\n", "line 3 is not two pieces"},
           {"header\na bc\n", "line 2 merges a piece that no"},
           {"header\na \n", "line 2 merges a piece that no"},
           {"header\na \xff\n", "line 2 merges a piece that no"},
           {"header\na b\na b\n", "line 3 makes a piece that an earlier"},
           {"header\na b\nb c\nab c\na bc\n", "line 5 makes a piece"},
           {"header\na</w> b\n", "line 2 merges something behind the end"}}) {
    const auto tokenizer = BytePairTokenizer::Parse(text);
    EXPECT_EQ(tokenizer.status().code(), StatusCode::kBadInput) << text;
    EXPECT_THAT(tokenizer.status().message(), HasSubstr(fault)) << text;
  }
}

TEST(BytePairTokenizerTest, ReadsPlainAndGzipFiles) {
  const TemporaryFolder folder;
  WriteText(folder / "plain", kMerges);
  WriteText(folder / "packed", Gzip(kMerges).value());
  WriteText(folder / "damaged", Gzip(kMerges).value().substr(0, 30));
  for (const char* name : {"plain", "packed"}) {
    const auto tokenizer = BytePairTokenizer::Load(folder / name);
    ASSERT_TRUE(tokenizer.ok()) << tokenizer.status().message();
    EXPECT_EQ(tokenizer->Tokenize("red apple", kContext)->ids,
              Ids("red apple"));
  }
  for (const char* name : {"damaged", "missing"}) {
    const auto tokenizer = BytePairTokenizer::Load(folder / name);
    EXPECT_EQ(tokenizer.status().code(), StatusCode::kBadInput);
    EXPECT_THAT(tokenizer.status().message(), HasSubstr(name));
  }
}

TEST(BytePairTokenizerTest, MatchesTheReference) {
  const std::filesystem::path folder = SharedData("clip");
  if (folder.empty()) GTEST_SKIP() << "FREEGS_SHARED_DATA has no clip";
  const auto tokenizer =
      BytePairTokenizer::Load(folder / "bpe_simple_vocab_16e6.txt.gz");
  ASSERT_TRUE(tokenizer.ok()) << tokenizer.status().message();
  EXPECT_EQ(tokenizer->start_token(), 49406);
  EXPECT_EQ(tokenizer->vocab_size(), 49408);
  const auto text = ReadFile(folder / "tokenizer_cases.json");
  ASSERT_TRUE(text.ok()) << text.status().message();
  const nlohmann::json cases = nlohmann::json::parse(*text)["cases"];
  EXPECT_GE(cases.size(), 172u);
  for (const nlohmann::json& reference : cases) {
    const auto caption = reference["text"].get<std::string>();
    const auto tokens = tokenizer->Tokenize(caption, kContext);
    ASSERT_TRUE(tokens.ok()) << tokens.status().message();
    EXPECT_EQ(tokens->ids, reference["ids"].get<std::vector<int32_t>>())
        << caption;
    EXPECT_EQ(tokens->truncated, reference["truncated"].get<bool>()) << caption;
  }
}

}  // namespace
}  // namespace freegs::semantics
