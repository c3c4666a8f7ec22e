// SPDX-License-Identifier: BSD-3-Clause
// What a page is told about the workspace and about a run under way.

#ifndef FREEGS_STAGES_VIEW_VIEW_STATUS_H_
#define FREEGS_STAGES_VIEW_VIEW_STATUS_H_

#include <filesystem>

#include <nlohmann/json_fwd.hpp>

namespace freegs::stages {

// The answer to GET /api/status; docs/view.md has the members. It reads a few
// small files and changes nothing, so that it can be asked every second.
nlohmann::json ViewStatus(const std::filesystem::path& workspace);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_VIEW_STATUS_H_
