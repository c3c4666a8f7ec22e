// SPDX-License-Identifier: BSD-3-Clause

#include "core/io/json_text.h"

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_fields.h"

namespace freegs {

using nlohmann::json;

std::string ValidUtf8(const std::string& text) {
  return ParseJson(JsonText(text, -1))->get<std::string>();
}

std::string JsonText(const json& document, int indent) {
  return document.dump(indent, ' ', false, json::error_handler_t::replace) +
         "\n";
}

StatusOr<json> ReadJson(const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string text,
                          ReadFile(path, uint64_t{1} << 28));
  return ParseJson(text, path.string());
}

}  // namespace freegs
