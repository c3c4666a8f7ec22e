// SPDX-License-Identifier: BSD-3-Clause

#include "tests/docs/pages.h"

#include <algorithm>
#include <cctype>
#include <regex>
#include <sstream>
#include <utility>

#include "tests/temporary_folder.h"

namespace freegs::docs {
namespace {

namespace fs = std::filesystem;

// The anchor of a heading: small letters, "-" for spaces, no punctuation.
std::string AnchorOf(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) || c == '-' || c == '_' || byte >= 0x80) {
      anchor += static_cast<char>(std::tolower(byte));
    } else if (c == ' ') {
      anchor += '-';
    }
  }
  return anchor;
}

void AddMatches(const std::string& line,
                const std::regex& pattern,
                std::vector<std::string>* matches) {
  for (std::sregex_iterator at(line.begin(), line.end(), pattern), end;
       at != end;
       ++at) {
    matches->push_back((*at)[1]);
  }
}

// Takes the next word off the text, without its quotes. False at the end of the
// command; then `rest` begins after what ended it.
bool TakeWord(std::string* rest, std::string* word) {
  word->clear();
  size_t at = rest->find_first_not_of(' ');
  if (at == std::string::npos || (*rest)[at] == '#' || at >= 3) {
    rest->clear();
    return false;
  }
  bool any = false;
  char quote = 0;
  for (; at < rest->size(); ++at) {
    const char c = (*rest)[at];
    if (quote != 0) {
      if (c == quote) {
        quote = 0;
      } else {
        *word += c;
      }
    } else if (c == '\'' || c == '"') {
      quote = c;
      any = true;
    } else if (c == ' ' || c == ';' ||
               (word->empty() && !any && (c == '|' || c == '&'))) {
      break;
    } else {
      *word += c;
    }
  }
  any = any || !word->empty();
  const size_t next = any ? at : rest->find_first_not_of("|&;", at);
  rest->erase(0, next);
  return any;
}

}  // namespace

Page ParsePage(fs::path path, std::string text) {
  const std::regex code("`([^`]+)`");
  const std::regex link(R"(\]\(([^)\s]+)\))");
  Page page{std::move(path), std::move(text), {}, {}, {}, {}};
  std::istringstream lines(page.text);
  bool fenced = false;
  bool indented = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```")) {
      fenced = !fenced;
      if (fenced) page.blocks.push_back({line.substr(3), {}});
      indented = false;
    } else if (fenced) {
      page.blocks.back().lines.push_back(line);
    } else if (line.starts_with("    ")) {
      if (!indented) page.blocks.emplace_back();
      indented = true;
      page.blocks.back().lines.push_back(line.substr(4));
    } else {
      indented = false;
      AddMatches(line, code, &page.code);
      AddMatches(line, link, &page.links);
      if (line.starts_with('#')) {
        const size_t title = line.find_first_not_of("# ");
        if (title != std::string::npos) {
          page.anchors.insert(AnchorOf(line.substr(title)));
        }
      }
    }
  }
  return page;
}

std::vector<Page> ReadPages(const fs::path& root) {
  std::vector<fs::path> paths = {root / "README.md",
                                 root / "workspace_template" / "README.md"};
  for (const auto& entry : fs::directory_iterator(root / "docs")) {
    if (entry.path().extension() == ".md") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<Page> pages;
  for (const fs::path& path : paths) {
    pages.push_back(ParsePage(path, ReadText(path)));
  }
  return pages;
}

std::vector<std::vector<std::string>> ShellCommands(const CodeBlock& block) {
  std::vector<std::vector<std::string>> commands;
  std::string joined;
  for (const std::string& line : block.lines) {
    joined += line.substr(std::min(line.find_first_not_of(' '), line.size()));
    if (joined.ends_with('\\')) {
      joined.back() = ' ';
      continue;
    }
    if (joined.starts_with("$ ")) joined.erase(0, 2);
    std::string rest = std::exchange(joined, "");
    while (!rest.empty()) {
      std::vector<std::string> words;
      std::string word;
      while (TakeWord(&rest, &word)) words.push_back(word);
      if (!words.empty()) commands.push_back(std::move(words));
    }
  }
  return commands;
}

}  // namespace freegs::docs
