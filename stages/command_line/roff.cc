// SPDX-License-Identifier: BSD-3-Clause

#include "stages/command_line/roff.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <sstream>

#include "core/text.h"
#include "stages/command_line/command_help.h"

namespace freegs::stages {
namespace {

bool IsLetter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}
bool IsCapital(char c) { return c >= 'A' && c <= 'Z'; }

// The number of the character of UTF-8 at `at`, which moves to the next one.
// Bytes that are no UTF-8 count as "?".
uint32_t TakeCharacter(std::string_view text, size_t* at) {
  const auto first = static_cast<unsigned char>(text[(*at)++]);
  if (first < 0x80) return first;
  const int more = first >= 0xf0   ? 3
                   : first >= 0xe0 ? 2
                   : first >= 0xc0 ? 1
                                   : 0;
  uint32_t number = first & (0x3fu >> more);
  for (int k = 0; k < more; ++k) {
    if (*at >= text.size() || (text[*at] & 0xc0) != 0x80) return '?';
    number =
        (number << 6) | (static_cast<unsigned char>(text[(*at)++]) & 0x3fu);
  }
  return more == 0 ? '?' : number;
}

// A line must not begin with what makes it a request of roff.
std::string ProtectedLine(const std::string& line) {
  return (line.starts_with('.') || line.starts_with('\'') ? "\\&" : "") + line;
}

// Whether a word is one of prose: letters, hyphens between them, and points and
// commas around them.
bool IsProse(std::string_view word) {
  const auto plain = [](char c) {
    return IsLetter(c) ||
           std::string_view("-.,;:()?!").find(c) != std::string_view::npos;
  };
  const size_t first = word.find_first_not_of("(");
  return first != std::string_view::npos && word[first] != '-' &&
         word.find('.') >= word.size() - 1 &&
         std::all_of(word.begin(), word.end(), plain);
}

}  // namespace

std::string RoffEscaped(std::string_view text, bool literal) {
  std::string result;
  for (size_t at = 0; at < text.size();) {
    const uint32_t character = TakeCharacter(text, &at);
    switch (character) {
      case '\\':
        result += "\\e";
        break;
      case '-':
        result += literal ? "\\-" : "-";
        break;
      case '\'':
        result += "\\(aq";
        break;
      case '`':
        result += "\\(ga";
        break;
      case '^':
        result += "\\(ha";
        break;
      case '~':
        result += "\\(ti";
        break;
      default:
        if (character < 0x80) {
          result += static_cast<char>(character);
        } else {
          std::array<char, 16> name;
          std::snprintf(name.data(), name.size(), "\\[u%04X]", character);
          result += name.data();
        }
    }
  }
  return result;
}

std::string RoffText(std::string_view text) {
  std::istringstream input{std::string(text)};
  std::string escaped;
  for (std::string word; input >> word;) {
    escaped += (escaped.empty() ? "" : " ") + RoffEscaped(word, !IsProse(word));
    // Two points at the end of a line do not end a sentence.
    if (word == "..") escaped += "\\&";
  }
  std::istringstream lines(WrapText(escaped, "", 0));
  std::string result;
  for (std::string line; std::getline(lines, line);) {
    result += ProtectedLine(line) + "\n";
  }
  return result;
}

std::string RoffUsage(std::string_view usage) {
  const auto in_word = [](char c) {
    return IsLetter(c) || IsDigit(c) || c == '_' || c == '-' || c == '.';
  };
  std::string result;
  for (size_t at = 0; at < usage.size();) {
    size_t end = at;
    while (end < usage.size() && in_word(usage[end])) ++end;
    if (end == at) {
      result += RoffEscaped(usage.substr(at++, 1), true);
      continue;
    }
    const std::string_view word = usage.substr(at, end - at);
    const bool stands_for_other =
        IsCapital(word[0]) &&
        std::none_of(word.begin(), word.end(), [](char c) {
          return IsLetter(c) && !IsCapital(c);
        });
    result +=
        (stands_for_other ? "\\fI" : "\\fB") + RoffEscaped(word, true) + "\\fR";
    at = end;
  }
  return ProtectedLine(result) + "\n";
}

std::string RoffExample(std::string_view lines) {
  std::istringstream input{std::string(lines)};
  std::string result;
  for (std::string line; std::getline(input, line);) {
    result += ProtectedLine(RoffEscaped(line, true)) + "\n";
  }
  return result;
}

}  // namespace freegs::stages
