// SPDX-License-Identifier: BSD-3-Clause
// JSON files of the workspace. File names need not be valid UTF-8; JSON must.

#ifndef FREEGS_PIPELINE_JSON_TEXT_H_
#define FREEGS_PIPELINE_JSON_TEXT_H_

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/status.h"

namespace freegs::pipeline {

// The text with every byte that is not valid UTF-8 replaced by U+FFFD: what a
// string becomes when written to JSON and read back.
std::string ValidUtf8(const std::string& text);

// The document with a final line break; indent -1 puts it on one line.
std::string JsonText(const nlohmann::json& json, int indent = 2);

// Parses a file of at most 256 MB; kBadInput if it is not JSON.
StatusOr<nlohmann::json> ReadJson(const std::filesystem::path& path);

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_JSON_TEXT_H_
