// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/shipped_model.h"

#include <system_error>

namespace freegs::stages {

namespace fs = std::filesystem;

StatusOr<fs::path> FindShippedModel() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path folder = program.parent_path().parent_path() / "share" /
                          "freegs_pipeline" / "models" / "small_clip";
  if (fs::is_directory(folder, error)) return folder;
  return MissingDependencyError(
      "the CLIP model that comes with the program is not in " +
      folder.string() + "; install the program whole, or name a model folder");
}

}  // namespace freegs::stages
