// SPDX-License-Identifier: BSD-3-Clause

#include "stages/query/file_stamp.h"

#include <sys/stat.h>

#include "core/io/files.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> FilesOfPhotos(const fs::path& workspace) {
  std::vector<fs::path> files = {workspace / "ingest" / "images.json"};
  const fs::path sparse = workspace / "undistort" / "sparse";
  for (const char* name : {"cameras", "images", "points3D"}) {
    for (const char* suffix : {".bin", ".txt"}) {
      files.push_back(sparse / (std::string(name) + suffix));
    }
  }
  return files;
}

}  // namespace

std::string FileStamp(const std::vector<fs::path>& files) {
  std::string text;
  for (const fs::path& file : files) {
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

std::string PhotosStamp(const fs::path& workspace) {
  return FileStamp(FilesOfPhotos(workspace));
}

std::string QueryStamp(const fs::path& workspace) {
  std::vector<fs::path> files = FilesOfPhotos(workspace);
  for (const char* name : {"undistort/stage.json",  // For the photos' pixels.
                           "reconstruct/point_cloud.ply",
                           "reconstruct/stage.json",
                           "reconstruct/exposure.json",
                           "bootstrap/idsf.bin",
                           "bootstrap/instances.json",
                           "bootstrap/instance_features.json",
                           "bootstrap/hierarchy.json",
                           "bootstrap/stage.json"}) {
    files.push_back(workspace / name);
  }
  return FileStamp(files);
}

}  // namespace freegs::stages
