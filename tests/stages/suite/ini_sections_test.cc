// SPDX-License-Identifier: BSD-3-Clause

#include "stages/suite/ini_sections.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

std::string IniFault(const std::string& text) {
  const auto sections = ParseIniSections(text, "s.ini");
  EXPECT_EQ(sections.status().code(), StatusCode::kInvalidArgument) << text;
  return sections.status().message();
}

TEST(IniSectionsTest, KeepsTheOrderAndDropsComments) {
  const auto sections = ParseIniSections(
      "\xef\xbb\xbf# A comment.\n"
      "[scene  red fox ]\n"
      "\tz = a b  # and another one\r\n"
      "a.b=1\n"
      "\n"
      "[suite]\n"
      "to = sfm",
      "s.ini");
  ASSERT_TRUE(sections.ok()) << sections.status().message();
  ASSERT_EQ(sections->size(), 2u);
  const IniSection& scene = (*sections)[0];
  EXPECT_EQ(scene.kind, "scene");
  EXPECT_EQ(scene.name, "red fox");
  EXPECT_EQ(scene.Title(), "[scene red fox]");
  EXPECT_THAT(scene.entries, ElementsAre(Pair("z", "a b"), Pair("a.b", "1")));
  EXPECT_EQ((*sections)[1].Title(), "[suite]");
  ASSERT_NE((*sections)[1].Find("to"), nullptr);
  EXPECT_EQ(*(*sections)[1].Find("to"), "sfm");
  EXPECT_EQ((*sections)[1].Find("from"), nullptr);
}

TEST(IniSectionsTest, NamesTheLineOfAFault) {
  EXPECT_THAT(IniFault("a = 1\n[suite]\nb = 2\n"),
              HasSubstr("s.ini: a stands before the first section"));
  EXPECT_THAT(IniFault("[one]\n[two]\nb = 2\n"),
              HasSubstr("s.ini: line 1: this section has no KEY"));
  EXPECT_THAT(IniFault("[one]\nb = 2\n[two]\n"), HasSubstr("line 3: "));
  EXPECT_THAT(IniFault("[one\nb = 2\n"), HasSubstr("line 1: a section is"));
  EXPECT_THAT(IniFault("[one]\nb = \x01\n"),
              HasSubstr("line 2: holds a control character"));
  EXPECT_THAT(IniFault("[one]\nwords\n"), HasSubstr("line 2: "));
  EXPECT_THAT(IniFault("[one]\nb = room#2\n"),
              HasSubstr("line 2: # begins a comment"));
  EXPECT_THAT(IniFault("[one]\nb = 2\nb = 3\n"), HasSubstr("line 3: "));
  EXPECT_THAT(IniFault("[one]\nb = 2\n[one]\nc = 3\n"), HasSubstr("line 3: "));
  EXPECT_THAT(IniFault(std::string((1 << 20) + 1, '\n')),
              HasSubstr("larger than 1 MiB"));
}

TEST(ExpandVariablesTest, PutsInWhatAVariableHolds) {
  const auto expand = [](const std::string& text) {
    return ExpandVariables(
        text, [](const std::string& name) -> std::optional<std::string> {
          if (name == "A") return "1${B}";
          if (name == "NONE") return "";
          return std::nullopt;
        });
  };
  EXPECT_EQ(expand("plain $A }").value(), "plain $A }");
  // The text of a variable is not expanded again.
  EXPECT_EQ(expand("${A}/x${NONE}${A}").value(), "1${B}/x1${B}");
  EXPECT_EQ(expand("").value(), "");
  for (const auto& [text, fault] :
       std::vector<std::pair<std::string, std::string>>{
           {"${B}", "the variable B is not set"}, {"${A", "without its }"}}) {
    const auto expanded = expand(text);
    EXPECT_EQ(expanded.status().code(), StatusCode::kInvalidArgument);
    EXPECT_THAT(expanded.status().message(), HasSubstr(fault));
  }
}

}  // namespace
}  // namespace freegs::stages
