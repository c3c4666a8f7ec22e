// SPDX-License-Identifier: BSD-3-Clause
// What is in the pages of docs/: blocks of code, command lines, the names of
// files, headings.

#ifndef FREEGS_TESTS_DOCS_PAGES_H_
#define FREEGS_TESTS_DOCS_PAGES_H_

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace freegs::docs {

// A block between ``` and ```, or lines that are indented by four spaces.
struct CodeBlock {
  std::string
      info;  // What follows the first ```: "sh test". Empty if indented.
  std::vector<std::string> lines;
};

struct Page {
  std::filesystem::path path;
  std::string text;
  std::vector<CodeBlock> blocks;

  // What is between ` and ` outside of the blocks.
  std::vector<std::string> code;

  // The targets of links and pictures: "sfm.md#result".
  std::vector<std::string> links;

  // The anchors of its headings, as GitHub makes them: "what-comes-out".
  std::set<std::string> anchors;
};

Page ParsePage(std::filesystem::path path, std::string text);

// Where README.md and docs/ are.
inline std::filesystem::path SourceFolder() { return FREEGS_SOURCE_DIR; }

// README.md, docs/ and the README of the workspace.
std::vector<Page> ReadPages(const std::filesystem::path& root);

// The words of each command of the shell in the lines of a block: comments are
// left out, lines that end in \ go on, and && ; | part commands. A text to the
// right of at least three spaces is a remark about the command.
std::vector<std::vector<std::string>> ShellCommands(const CodeBlock& block);

}  // namespace freegs::docs

#endif  // FREEGS_TESTS_DOCS_PAGES_H_
