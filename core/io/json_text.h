// SPDX-License-Identifier: BSD-3-Clause
// Reads and writes JSON. It must be valid UTF-8, but names of files need not
// be. A file that parses or writes JSON by itself takes seconds longer to
// compile than one that calls these functions.

#ifndef FREEGS_CORE_IO_JSON_TEXT_H_
#define FREEGS_CORE_IO_JSON_TEXT_H_

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/status.h"

namespace freegs {

// Returns the text with every byte that is not valid UTF-8 replaced by U+FFFD.
// A string becomes this when it is written to JSON and read back.
std::string ValidUtf8(const std::string& text);

// Returns the text of the document, with a line break at its end. An indent of
// -1 puts everything on one line.
std::string JsonText(const nlohmann::json& json, int indent = 2);

// Parses a file of at most 256 MB. Returns kBadInput if it is not JSON or if it
// is nested too deeply (see ParseJson).
StatusOr<nlohmann::json> ReadJson(const std::filesystem::path& path);

}  // namespace freegs

#endif  // FREEGS_CORE_IO_JSON_TEXT_H_
