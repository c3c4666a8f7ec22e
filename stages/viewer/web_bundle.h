// SPDX-License-Identifier: BSD-3-Clause
// Finds the page's script, which is bundled from web/ when the program is
// built.

#ifndef FREEGS_STAGES_VIEWER_WEB_BUNDLE_H_
#define FREEGS_STAGES_VIEWER_WEB_BUNDLE_H_

#include <filesystem>

#include "core/status.h"

namespace freegs::stages {

// Returns the folder with viewer.js, viewer.css, live.html and licenses.txt:
// ../share/freegs_pipeline/web as seen from the folder of the executable, in a
// build folder as well as where the program is installed. kMissingDependency,
// which says how it is built, when it is not there.
StatusOr<std::filesystem::path> FindWebBundle();

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEWER_WEB_BUNDLE_H_
