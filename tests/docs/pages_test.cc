// SPDX-License-Identifier: BSD-3-Clause
// The pages name only files, headings and words of the command line that exist.

#include "tests/docs/pages.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stages/command_line/completion_values.h"
#include "stages/commands/command_list.h"
#include "tests/temporary_folder.h"

namespace freegs::docs {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

// Endings of files that are in the sources. Other files with a folder before
// them are those of a workspace or of the user.
bool IsSource(const std::string& name) {
  static const std::set<std::string> kEndings = {
      ".h", ".cc", ".md", ".py", ".sh", ".cmake", ".ts", ".mjs", ".in"};
  return kEndings.contains(fs::path(name).extension().string());
}

// The files of the sources that a page names: in its sentences, in its prose as
// "docs/sfm.md", and as words of commands.
std::vector<std::string> NamedFiles(const Page& page) {
  static const std::regex kPath("[A-Za-z_0-9.-]+(/[A-Za-z_0-9.-]+)+");
  static const std::regex kPageName("docs/[a-z_]+\\.md");
  std::vector<std::string> names;
  for (const std::string& code : page.code) {
    std::string name = code.substr(0, code.find(' '));
    if (name.starts_with("./")) name.erase(0, 2);
    if (std::regex_match(name, kPath) && IsSource(name) &&
        name.find("...") == std::string::npos &&
        name.find("NAME") == std::string::npos) {
      names.push_back(name);
    }
  }
  for (std::sregex_iterator at(page.text.begin(), page.text.end(), kPageName),
       end;
       at != end;
       ++at) {
    names.push_back(at->str());
  }
  for (const CodeBlock& block : page.blocks) {
    for (const std::vector<std::string>& words : ShellCommands(block)) {
      for (std::string name : words) {
        if (name.starts_with("./")) name.erase(0, 2);
        const std::string folder = name.substr(0, name.find('/'));
        if (name != folder && (folder == "bench" || folder == "scripts" ||
                               folder == "tests" || folder == "examples")) {
          names.push_back(name);
        }
      }
    }
  }
  return names;
}

TEST(PagesTest, FilesThatArePartOfTheSourcesExist) {
  size_t seen = 0;
  for (const Page& page : ReadPages(SourceFolder())) {
    for (const std::string& name : NamedFiles(page)) {
      EXPECT_TRUE(fs::exists(SourceFolder() / name))
          << page.path << ": " << name;
      ++seen;
    }
  }
  EXPECT_GT(seen, 50u);
}

TEST(PagesTest, LinksLeadSomewhere) {
  std::map<fs::path, std::set<std::string>> anchors;
  for (const Page& page : ReadPages(SourceFolder())) {
    anchors[page.path.lexically_normal()] = page.anchors;
  }
  for (const Page& page : ReadPages(SourceFolder())) {
    for (const std::string& link : page.links) {
      if (link.find("://") != std::string::npos) continue;
      const std::string file = link.substr(0, link.find('#'));
      const fs::path target =
          file.empty() ? page.path
                       : (page.path.parent_path() / file).lexically_normal();
      EXPECT_TRUE(fs::exists(target)) << page.path << ": " << link;
      const auto found = anchors.find(target);
      if (link.find('#') == std::string::npos || found == anchors.end()) {
        continue;
      }
      const std::string anchor = link.substr(link.find('#') + 1);
      EXPECT_TRUE(found->second.contains(anchor))
          << page.path << ": " << link << " names no heading";
    }
  }
}

TEST(PagesTest, EveryPageIsInTheIndex) {
  const Page index = ParsePage(SourceFolder() / "docs" / "README.md",
                               ReadText(SourceFolder() / "docs/README.md"));
  const std::set<std::string> links(index.links.begin(), index.links.end());
  for (const auto& entry : fs::directory_iterator(SourceFolder() / "docs")) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() != ".md" || name == "README.md") continue;
    EXPECT_TRUE(links.contains(name))
        << "docs/README.md does not name " << name;
  }
}

std::set<std::string> OptionWords(const stages::CommandWords& words) {
  std::set<std::string> names;
  for (const stages::CompletedOption& option : CompletedOptions(words)) {
    names.insert(option.word);
  }
  return names;
}

TEST(PagesTest, OptionsExist) {
  const std::set<std::string> of_run =
      OptionWords(stages::FindCommand("run")->words());
  const std::regex command_line("freegs_pipeline ([a-z]+)([^`\n|;&]*)");
  const std::regex option("--[a-z][a-z_.-]*[a-z]");
  const std::regex with_section("--[a-z]+\\.[a-z_]+");
  int seen = 0;
  for (const Page& page : ReadPages(SourceFolder())) {
    const std::string text =
        std::regex_replace(page.text, std::regex("\\\\\n"), " ");
    const auto end = std::sregex_iterator();
    for (std::sregex_iterator at(text.begin(), text.end(), command_line);
         at != end;
         ++at) {
      const auto command = stages::FindCommand((*at)[1]);
      if (!command.ok()) continue;  // A word of a sentence.
      const std::set<std::string> known = OptionWords(command->words());
      const std::string rest = (*at)[2];
      for (std::sregex_iterator word(rest.begin(), rest.end(), option);
           word != end;
           ++word) {
        EXPECT_TRUE(known.contains(word->str())) << page.path << at->str();
        ++seen;
      }
    }
    for (std::sregex_iterator at(text.begin(), text.end(), with_section);
         at != end;
         ++at) {
      EXPECT_TRUE(of_run.contains(at->str())) << page.path << at->str();
    }
  }
  EXPECT_GT(seen, 10);
}

// Whether a command tells how it is called and stands for many: "[--json]",
// "a|b", "...".
bool IsSynopsis(const std::vector<std::string>& words) {
  return std::any_of(words.begin(), words.end(), [](const std::string& word) {
    return word.find_first_of("[]()|<>") != std::string::npos ||
           word.ends_with("...");
  });
}

// Capital letters that stand for a number or a choice: "--port N".
std::string WithoutPlaceholders(const stages::CommandWords& command,
                                const std::string& option,
                                const std::string& word) {
  const bool placeholder =
      !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
        return (c >= 'A' && c <= 'Z') || c == '_';
      });
  const auto* found = command.table().Find(option);
  if (!placeholder || found == nullptr) return word;
  if (!found->default_value.empty()) return found->default_value;
  return found->spec.choices.empty() ? word : found->spec.choices.front();
}

// What is wrong with a command line of the program, if anything.
std::string Fault(const std::vector<std::string>& words) {
  if (words.size() < 2 || words[1].starts_with("--")) return "";
  const auto command = stages::FindCommand(words[1]);
  if (!command.ok()) return command.status().message();
  stages::CommandWords declared = command->words();
  std::vector<std::string> arguments;
  for (size_t k = 2; k < words.size(); ++k) {
    if (words[k] == "--help" || words[k].starts_with("<(")) return "";
    if (words[k] == ">" || words[k] == ">>") break;
    const std::string option =
        words[k - 1].starts_with("--") ? words[k - 1].substr(2) : "";
    arguments.push_back(WithoutPlaceholders(declared, option, words[k]));
    for (const stages::Argument& argument : declared.arguments()) {
      if (words[k] != argument.name || argument.choices.empty()) continue;
      arguments.back() = argument.choices.front();
    }
  }
  const auto parsed = declared.Parse(arguments);
  return parsed.ok() ? "" : parsed.status().message();
}

TEST(PagesTest, CommandLinesAreUnderstood) {
  int seen = 0;
  for (const Page& page : ReadPages(SourceFolder())) {
    for (const CodeBlock& block : page.blocks) {
      for (const std::vector<std::string>& words : ShellCommands(block)) {
        const fs::path program(words[0]);
        if (program.filename() != "freegs_pipeline" || IsSynopsis(words)) {
          continue;
        }
        EXPECT_EQ(Fault(words), "")
            << page.path << ": " << testing::PrintToString(words);
        ++seen;
      }
    }
  }
  EXPECT_GT(seen, 20);
}

TEST(ParsePageTest, FindsCodeLinksAndHeadings) {
  const Page page = ParsePage("a.md",
                              "# A, b: `c d`\n\n    ls x\n    ls y\n\ntext "
                              "`core/image.h` [t](b.md#c)\n```sh test\nrun\n"
                              "```\n## A_b 2\n");
  ASSERT_EQ(page.blocks.size(), 2u);
  EXPECT_THAT(page.blocks[0].lines, ElementsAre("ls x", "ls y"));
  EXPECT_EQ(page.blocks[1].info, "sh test");
  EXPECT_THAT(page.code, ElementsAre("c d", "core/image.h"));
  EXPECT_THAT(page.links, ElementsAre("b.md#c"));
  EXPECT_THAT(page.anchors, UnorderedElementsAre("a-b-c-d", "a_b-2"));
}

TEST(ShellCommandsTest, WordsAsTheShellTakesThem) {
  const CodeBlock block{"",
                        {"$ a --text \"red apple\" x   # remark",
                         "b 'c d' && e; f | g",
                         "h \\",
                         "    i",
                         "j k      what it does",
                         "# nothing"}};
  EXPECT_THAT(ShellCommands(block),
              ElementsAre(ElementsAre("a", "--text", "red apple", "x"),
                          ElementsAre("b", "c d"),
                          ElementsAre("e"),
                          ElementsAre("f"),
                          ElementsAre("g"),
                          ElementsAre("h", "i"),
                          ElementsAre("j", "k")));
  EXPECT_THAT(ShellCommands({}), IsEmpty());
}

}  // namespace
}  // namespace freegs::docs
