// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/html.h"

#include "core/io/json_text.h"
#include "core/text.h"

namespace freegs::stages {

std::string EscapeHtml(std::string_view text) {
  std::string escaped;
  for (const char c : ValidUtf8(std::string(text))) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        if ((static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') ||
            c == 0x7f) {
          escaped += "\ufffd";
        } else {
          escaped += c;
        }
    }
  }
  return escaped;
}

std::string EncodeUrlPath(std::string_view path) {
  constexpr std::string_view kPlain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~/";
  return PercentEncode(path, [kPlain](char c) {
    return kPlain.find(c) != std::string_view::npos;
  });
}

std::string JsonForScript(std::string json) {
  for (size_t at = 0; (at = json.find('<', at)) != std::string::npos;) {
    json.replace(at, 1, "\\u003c");
  }
  return json;
}

}  // namespace freegs::stages
