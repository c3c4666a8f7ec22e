// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/output_files.h"

#include <iterator>
#include <system_error>

#include "core/io/json_text.h"
#include "core/text.h"
#include "pipeline/fingerprint.h"

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;

void AddFile(const fs::path& folder, const fs::path& file, OutputFiles* files) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  if (error) return;
  // Names are kept as JSON can hold them.
  const std::string name = ValidUtf8(file.lexically_relative(folder).string());
  (*files)[name] = static_cast<int64_t>(size);
}

// Whether a file is a bystander or lies in a folder that is one.
bool IsBesideOutputs(const fs::path& file) {
  for (auto part = file.begin(); part != file.end(); ++part) {
    if (IsBystander(part->string(), std::next(part) != file.end())) return true;
  }
  return false;
}

}  // namespace

OutputFiles ListOutputFiles(const fs::path& folder,
                            const std::vector<fs::path>& parts) {
  OutputFiles files;
  for (const fs::path& part : parts) {
    std::error_code error;
    AddFile(folder, folder / part, &files);
    for (fs::recursive_directory_iterator it(folder / part, error), end;
         !error && it != end;
         it.increment(error)) {
      AddFile(folder, it->path(), &files);
    }
  }
  return files;
}

OutputChange CompareOutputFiles(const OutputFiles& then,
                                const OutputFiles& now) {
  std::vector<std::string> missing;
  std::vector<std::string> replaced;
  for (const auto& [name, size] : then) {
    const auto found = now.find(name);
    if (found == now.end() || (found->second == 0 && size > 0)) {
      missing.push_back(name);
    } else if (found->second != size) {
      replaced.push_back(name);
    }
  }
  for (const auto& [name, size] : now) {
    if (!then.contains(name) && !IsBesideOutputs(name)) {
      replaced.push_back(name);
    }
  }
  // Other files in place of those that are missing: not to be overwritten.
  if (!replaced.empty()) return {"", SomeNames(replaced, 1)};
  return {SomeNames(missing, 1), ""};
}

}  // namespace freegs::pipeline
