// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/web_bundle.h"

#include <system_error>

namespace freegs::stages {

namespace fs = std::filesystem;

StatusOr<fs::path> FindWebBundle() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path folder =
      program.parent_path().parent_path() / "share" / "freegs_pipeline" / "web";
  if (fs::is_directory(folder, error)) return folder;
  return MissingDependencyError(folder.string() +
                                ": the page of the 3D viewer is not there; "
                                "build the program with it");
}

}  // namespace freegs::stages
