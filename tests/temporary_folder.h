// SPDX-License-Identifier: BSD-3-Clause
// A folder for the files of a test, and the files in it.

#ifndef FREEGS_TESTS_TEMPORARY_FOLDER_H_
#define FREEGS_TESTS_TEMPORARY_FOLDER_H_

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>

namespace freegs {

// Writes a file, making its folders.
inline void WriteText(const std::filesystem::path& path,
                      std::string_view text) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

// A new, empty folder that is deleted with the object:
//
//   const TemporaryFolder folder;
//   folder.Write("photos/a.jpg", bytes);
//   ReadSomething(folder / "photos/a.jpg");
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name =
        (std::filesystem::temp_directory_path() / "freegs_test_XXXXXX")
            .string();
    if (mkdtemp(name.data()) == nullptr) std::abort();
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const {
    return path_ / name;
  }

  // Writes a file of the folder and makes the folders above it.
  void Write(const std::string& name, std::string_view bytes) const {
    WriteText(path_ / name, bytes);
  }

 private:
  std::filesystem::path path_;
};

// The content of a file; empty if there is none.
inline std::string ReadText(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace freegs

#endif  // FREEGS_TESTS_TEMPORARY_FOLDER_H_
