// SPDX-License-Identifier: BSD-3-Clause
// Notices when somebody deletes or replaces files in a stage's finished output.

#ifndef FREEGS_PIPELINE_OUTPUT_FILES_H_
#define FREEGS_PIPELINE_OUTPUT_FILES_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace freegs::pipeline {

// The sizes in bytes of files, by their paths below the folder of a stage.
using OutputFiles = std::map<std::string, int64_t>;

// Lists those of the files and folders `parts`, given relative to `folder`,
// that exist.
OutputFiles ListOutputFiles(const std::filesystem::path& folder,
                            const std::vector<std::filesystem::path>& parts);

// What became of an output. Each is a few words, or empty.
struct OutputChange {
  // Files are gone or empty, and nothing has come in their place.
  std::string missing;

  // Files are others than before, as when somebody has put a result of another
  // program there.
  std::string replaced;
};
OutputChange CompareOutputFiles(const OutputFiles& then,
                                const OutputFiles& now);

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_OUTPUT_FILES_H_
