// SPDX-License-Identifier: BSD-3-Clause
// The declaration of a command's words: what is accepted, and what the messages
// about the rest say.

#include "stages/command_line/command_words.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct DrawRequest {
  std::string out;
  std::string text;
  int size = 3;
  std::vector<std::vector<std::string>> click;
  std::vector<std::vector<std::string>> drop;
};

CommandWords DescribeDraw(DrawRequest* request) {
  CommandWords words("draw", "Draws.");
  words.AddArgument({.name = "IMAGE", .help = "A.", .optional = true});
  words.AddArgument({.name = "KIND", .help = "B.", .choices = {"ink", "oil"}});
  words.AddOption("out", &request->out, {.help = "O.", .value_name = "DIR"});
  words.AddLetter('o', "out");
  words.AddOption("text", &request->text, {.help = "T."});
  words.AddOption("size", &request->size, {.help = "S.", .min = 1});
  words.AddListOption({.name = "click",
                       .value_names = {"X", "Y"},
                       .help = "C.",
                       .target = &request->click});
  words.AddListOption({.name = "drop",
                       .value_names = {"KEY"},
                       .help = "D.",
                       .target = &request->drop,
                       .repeats = true});
  words.Require("out");
  words.RequireOneOf({"text", "click"});
  return words;
}

class CommandWordsTest : public ::testing::Test {
 protected:
  StatusOr<std::vector<std::string>> Parse(
      const std::vector<std::string>& arguments) {
    request_ = DrawRequest();
    return DescribeDraw(&request_).ParseAndApply(arguments);
  }

  std::string Error(const std::vector<std::string>& arguments) {
    const auto result = Parse(arguments);
    EXPECT_EQ(result.status().code(), StatusCode::kInvalidArgument);
    return result.status().message();
  }

  DrawRequest request_;
};

TEST_F(CommandWordsTest, FillsItsTargets) {
  const auto words = Parse({"a.png",
                            "--click",
                            "-1",
                            "2",
                            "ink",
                            "-o",
                            "folder",
                            "--drop",
                            "a",
                            "--drop=b"});
  ASSERT_TRUE(words.ok()) << words.status().message();
  EXPECT_THAT(*words, ElementsAre("a.png", "ink"));
  EXPECT_EQ(request_.out, "folder");
  EXPECT_THAT(request_.click, ElementsAre(ElementsAre("-1", "2")));
  EXPECT_THAT(request_.drop, ElementsAre(ElementsAre("a"), ElementsAre("b")));
  EXPECT_EQ(request_.size, 3);
}

TEST_F(CommandWordsTest, OptionalArgumentsMayBeLeftOut) {
  const auto words = Parse({"oil", "--out", "x", "--text", "y"});
  ASSERT_TRUE(words.ok()) << words.status().message();
  EXPECT_THAT(*words, ElementsAre("oil"));
}

TEST_F(CommandWordsTest, MessagesShowTheUsage) {
  const std::string usage =
      "draw [IMAGE] KIND --out DIR (--text TEXT | --click X Y) [OPTIONS]";
  EXPECT_EQ(CommandWords(KeepWords<DrawRequest>(DescribeDraw)).Usage(), usage);
  EXPECT_THAT(Error({}), HasSubstr(usage));
  EXPECT_THAT(Error({"a", "b", "c"}), HasSubstr("3 words"));
  EXPECT_THAT(Error({"oil", "--text", "y"}), HasSubstr("needs --out DIR"));
  EXPECT_THAT(Error({"oil", "--out", "", "--text", "y"}),
              HasSubstr("--out has an empty value"));
  EXPECT_THAT(Error({"oil", "--out", "x"}), HasSubstr("--text, --click"));
  EXPECT_THAT(Error({"oil", "--out", "x", "--text", "y", "--click", "1", "2"}),
              HasSubstr("exactly one"));
  EXPECT_THAT(Error({"oil", "--click", "1"}), HasSubstr("needs X Y"));
  EXPECT_THAT(Error({"oil", "--click", "1", "--out", "x"}),
              HasSubstr("needs X Y"));
  EXPECT_THAT(Error({"--click", "1", "2", "--click", "1", "2"}),
              HasSubstr("given twice"));
  EXPECT_THAT(Error({"a.png", "oli", "-o", "x"}),
              AllOf(HasSubstr("did you mean oil?"), HasSubstr("ink, oil")));
  EXPECT_THAT(Error({"oil", "--size", "0"}), HasSubstr("at least 1"));
  EXPECT_THAT(Error({"oil", "--sise", "2"}), HasSubstr("did you mean size?"));
}

TEST_F(CommandWordsTest, WordsOutliveTheFunctionThatMadeThem) {
  CommandWords words = KeepWords<DrawRequest>(DescribeDraw);
  const auto positional =
      words.ParseAndApply({"ink", "--out", "x", "--text", "y"});
  ASSERT_TRUE(positional.ok());
  EXPECT_EQ(words.table().Find("out")->value(), "x");
  EXPECT_EQ(words.table().Find("out")->default_value, "");
}

TEST(AbsoluteFolderTest, TheFolderAboveALinkIsThatOfItsTarget) {
  namespace fs = std::filesystem;
  const TemporaryFolder folder;
  const fs::path root = fs::canonical(folder.path());
  fs::create_directories(root / "far" / "photos");
  fs::create_directory_symlink("far/photos", root / "link");
  EXPECT_EQ(AbsoluteFolder((root / "link/").string()), root / "link");
  EXPECT_EQ(AbsoluteFolder((root / "link/../new/").string()),
            root / "far" / "new");
  EXPECT_EQ(AbsoluteFolder((root / "link/..").string()), root / "far");
  EXPECT_EQ(AbsoluteFolder("photos/"), fs::current_path() / "photos");
}

TEST(ExistingWorkspaceTest, IsAnAbsoluteFolder) {
  const TemporaryFolder folder;
  folder.Write("w/log.txt", "");
  const std::string path = (folder / "w").string();
  for (const std::string& word : {path, path + "/", path + "/."}) {
    const auto workspace = ExistingWorkspace(word);
    ASSERT_TRUE(workspace.ok()) << workspace.status().message();
    EXPECT_EQ(*workspace, path) << word;
  }
  for (const std::string& word : {path + "x", path + "/log.txt"}) {
    const auto workspace = ExistingWorkspace(word);
    EXPECT_EQ(workspace.status().code(), StatusCode::kBadInput);
    EXPECT_EQ(workspace.status().message(), word + ": no such workspace");
  }
}

TEST(CompletionOfTest, NamesOfValuesTellWhatTheyAre) {
  EXPECT_EQ(CompletionOf("WORKSPACE"), Completion::kFolders);
  EXPECT_EQ(CompletionOf("IMAGES"), Completion::kFiles);
  EXPECT_EQ(CompletionOf("N"), Completion::kNothing);
}

}  // namespace
}  // namespace freegs::stages
