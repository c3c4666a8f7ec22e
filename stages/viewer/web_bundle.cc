// SPDX-License-Identifier: BSD-3-Clause

#include "stages/viewer/web_bundle.h"

#include <system_error>

namespace freegs::stages {

namespace fs = std::filesystem;

StatusOr<fs::path> FindWebBundle() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path folder =
      program.parent_path().parent_path() / "share" / "freegs_pipeline" / "web";
  if (fs::exists(folder / "viewer.js", error)) return folder;
  return MissingDependencyError(
      "the 3D view is not built: " + (folder / "viewer.js").string() +
      " is not there; install Node.js 18 or newer with npm and build the "
      "program again");
}

}  // namespace freegs::stages
