// SPDX-License-Identifier: BSD-3-Clause

#include "stages/query/file_stamp.h"

#include <sys/stat.h>

#include "core/io/files.h"

namespace freegs::stages {

std::string FileStamp(const std::vector<std::filesystem::path>& files) {
  std::string text;
  for (const std::filesystem::path& file : files) {
    struct stat facts = {};
    if (stat(file.c_str(), &facts) == 0) {
      text += std::to_string(facts.st_ino) + " " +
              std::to_string(facts.st_size) + " " +
              std::to_string(facts.st_mtim.tv_sec) + " " +
              std::to_string(facts.st_mtim.tv_nsec);
    }
    text += ";";
  }
  return HashBytes(text).substr(0, 16);
}

std::string QueryStamp(const std::filesystem::path& workspace) {
  std::vector<std::filesystem::path> files;
  for (const char* name : {"undistort/sparse/images.bin",
                           "undistort/sparse/images.txt",
                           "undistort/stage.json",
                           "reconstruct/point_cloud.ply",
                           "bootstrap/idsf.bin",
                           "bootstrap/instances.json",
                           "bootstrap/instance_features.json",
                           "bootstrap/hierarchy.json"}) {
    files.push_back(workspace / name);
  }
  return FileStamp(files);
}

}  // namespace freegs::stages
