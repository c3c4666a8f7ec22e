// SPDX-License-Identifier: BSD-3-Clause
// Reference data that some tests want and the project does without.

#ifndef FREEGS_TESTS_SHARED_DATA_H_
#define FREEGS_TESTS_SHARED_DATA_H_

#include <cstdlib>
#include <filesystem>

namespace freegs {

// The folder `name` of the reference data, which FREEGS_SHARED_DATA names.
// Empty where there is none: the test is then skipped.
inline std::filesystem::path SharedData(const std::filesystem::path& name) {
  const char* data = std::getenv("FREEGS_SHARED_DATA");
  if (data == nullptr || *data == '\0') return {};
  const std::filesystem::path folder = std::filesystem::path(data) / name;
  return std::filesystem::exists(folder) ? folder : std::filesystem::path();
}

}  // namespace freegs

#endif  // FREEGS_TESTS_SHARED_DATA_H_
