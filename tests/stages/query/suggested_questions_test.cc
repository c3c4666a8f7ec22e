// SPDX-License-Identifier: BSD-3-Clause

#include "stages/query/suggested_questions.h"

#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/stages/synthetic_workspace.h"

namespace freegs::stages {
namespace {

using testing::ElementsAre;
using Question = std::vector<std::string>;

class SuggestedQuestionsTest : public testing::Test {
 protected:
  SuggestedQuestionsTest() { workspace_.AddInstances(); }

  // The map of the view that is asked about: instance `left`
  // has its left half, `corner` a bit of the rest, and `whole` a square in it.
  void WriteMap(int left, int corner, int whole = 0) {
    constexpr int kWidth = SyntheticWorkspace::kWidth;
    constexpr int kHeight = SyntheticWorkspace::kHeight;
    ImageU16 map(kWidth, kHeight, 1);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (x < kWidth / 2) map(x, y) = static_cast<uint16_t>(left);
        if (x > kWidth - 5 && y < 5) map(x, y) = static_cast<uint16_t>(corner);
        if (std::abs(x - 49) < 3 && std::abs(y - 33) < 3) {
          map(x, y) = static_cast<uint16_t>(whole);
        }
      }
    }
    // Every third of the six photos is held out: 1, 2, 4, 5 train.
    const auto folder = workspace_ / "bootstrap/instances";
    std::filesystem::create_directories(folder);
    ASSERT_TRUE(WriteLabels(folder / "photo4.png", map).ok());
  }

  void Name(int id, const std::string& name) {
    workspace_.instances[id - 1].words = {name};
    ASSERT_TRUE(
        semantics::WriteInstances(workspace_ / "bootstrap/instances.json",
                                  workspace_.instances)
            .ok());
  }

  SyntheticWorkspace workspace_;
};

TEST_F(SuggestedQuestionsTest, NamesFirstThenClicksOnWhatHasNone) {
  Name(2, "red ball");
  WriteMap(3, 1);
  const auto questions = SuggestQuestions(workspace_.path(), 3);
  ASSERT_TRUE(questions.ok()) << questions.status().message();
  ASSERT_EQ(questions->size(), 3u);
  EXPECT_THAT((*questions)[0], ElementsAre("--text", "red ball"));
  // The middle of the left half.
  EXPECT_THAT((*questions)[1],
              ElementsAre("--click", "photo4.png", "15", "15"));
  EXPECT_EQ((*questions)[2][0], "--click");
}

TEST_F(SuggestedQuestionsTest, OneNameIsAskedOnceAndAClickAlways) {
  for (const int id : {1, 2, 3}) Name(id, id == 3 ? "cup" : "red ball");
  WriteMap(1, 0);
  auto questions = SuggestQuestions(workspace_.path(), 4);
  ASSERT_TRUE(questions.ok());
  EXPECT_EQ(questions->size(), 2u);  // Nothing is left to click on.
  questions = SuggestQuestions(workspace_.path(), 1);
  ASSERT_TRUE(questions.ok());
  ASSERT_EQ(questions->size(), 1u);
  EXPECT_EQ((*questions)[0][0], "--click");
}

TEST_F(SuggestedQuestionsTest, WhatIsSeenWholeComesFirst) {
  WriteMap(1, 3, 2);
  const auto questions = SuggestQuestions(workspace_.path(), 2);
  ASSERT_TRUE(questions.ok());
  EXPECT_THAT(*questions,
              ElementsAre(ElementsAre("--click", "photo4.png", "49", "33"),
                          ElementsAre("--click", "photo4.png", "15", "15")));
}

TEST_F(SuggestedQuestionsTest, LargePlanesAreNotAskedFor) {
  workspace_.instances[2].background = true;
  Name(3, "white wall");
  WriteMap(3, 1);
  const auto questions = SuggestQuestions(workspace_.path(), 3);
  ASSERT_TRUE(questions.ok());
  ASSERT_EQ(questions->size(), 1u);
  EXPECT_EQ((*questions)[0][0], "--click");
}

TEST_F(SuggestedQuestionsTest, AnIncompleteWorkspaceIsNamed) {
  const Status no_map = SuggestQuestions(workspace_.path(), 3).status();
  EXPECT_EQ(no_map.code(), StatusCode::kBadInput);
  EXPECT_THAT(std::string(no_map.message()), testing::HasSubstr("photo4.png"));
  std::filesystem::remove(workspace_ / "bootstrap/instances.json");
  EXPECT_EQ(SuggestQuestions(workspace_.path(), 3).status().code(),
            StatusCode::kBadInput);
}

}  // namespace
}  // namespace freegs::stages
