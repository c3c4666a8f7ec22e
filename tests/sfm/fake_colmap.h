// SPDX-License-Identifier: BSD-3-Clause
// How tests use the fake COLMAP program.

#ifndef FREEGS_TESTS_SFM_FAKE_COLMAP_H_
#define FREEGS_TESTS_SFM_FAKE_COLMAP_H_

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/temporary_folder.h"

namespace freegs::sfm {

// A program in `folder` that runs the fake COLMAP (see fake_colmap.cc) with the
// given settings, such as {"FAKE_COLMAP_DIALECT", "4"}.
inline std::string MakeFakeColmap(
    const std::filesystem::path& folder,
    const std::vector<std::pair<std::string, std::string>>& settings = {}) {
  const std::filesystem::path path = folder / "colmap";
  std::string script = "#!/bin/sh\n";
  for (const auto& [name, value] : settings) {
    script += "export " + name + "='" + value + "'\n";
  }
  script += "exec '" FREEGS_FAKE_COLMAP "' \"$@\"\n";
  WriteText(path, script);
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  return path.string();
}

}  // namespace freegs::sfm

#endif  // FREEGS_TESTS_SFM_FAKE_COLMAP_H_
