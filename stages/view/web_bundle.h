// SPDX-License-Identifier: BSD-3-Clause
// Finds the files of the page that come with the program.

#ifndef FREEGS_STAGES_VIEW_WEB_BUNDLE_H_
#define FREEGS_STAGES_VIEW_WEB_BUNDLE_H_

#include <filesystem>

#include "core/status.h"

namespace freegs::stages {

// Returns ../share/freegs_pipeline/web as seen from the folder of the
// executable, for a build as for an installed program. kMissingDependency when
// the page was not built.
StatusOr<std::filesystem::path> FindWebBundle();

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_WEB_BUNDLE_H_
