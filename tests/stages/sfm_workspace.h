// SPDX-License-Identifier: BSD-3-Clause
// A workspace after ingest, and what runs a stage on it, for tests of the
// stages around COLMAP.

#ifndef FREEGS_TESTS_STAGES_SFM_WORKSPACE_H_
#define FREEGS_TESTS_STAGES_SFM_WORKSPACE_H_

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/image_io.h"
#include "core/parallel.h"
#include "photos/photo_list.h"
#include "pipeline/stage.h"
#include "tests/sfm/synthetic_model.h"
#include "tests/sfm/textured_photo.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {

class SfmWorkspace {
 public:
  // num_photos photos of 640 x 480 pixels, every 8th held out, named as those
  // of sfm::SyntheticModel.
  explicit SfmWorkspace(int num_photos) {
    std::filesystem::create_directories(path() / "ingest" / "photos");
    for (int i = 0; i < num_photos; ++i) {
      photos::Photo photo;
      photo.name = sfm::PhotoName(i);
      photo.file = "my " + photo.name;
      photo.width = 640;
      photo.height = 480;
      photo.hash = "hash" + std::to_string(i);
      photo.file_hash = photo.hash;
      photo.camera_group = 0;
      photo.split = i % 8 == 0 ? photos::PhotoSplit::kHoldout
                               : photos::PhotoSplit::kTrain;
      list.photos.push_back(photo);
      EXPECT_TRUE(WriteImage(path() / "ingest" / "photos" / photo.name,
                             sfm::TexturedPhoto(160, 120, 1))
                      .ok());
    }
    photos::Photo rejected;
    rejected.file = "broken.jpg";
    rejected.split = photos::PhotoSplit::kRejected;
    rejected.reason = "cannot be decoded";
    list.photos.push_back(rejected);
    WriteList();
  }

  void WriteList() {
    written = photos::WritePhotoList(path() / "ingest" / "images.json", list);
  }

  // Runs a stage into NAME.partial and, if it succeeded, moves that to NAME.
  Status Run(pipeline::Stage& stage) {
    if (!written.ok()) return written;
    ThreadPool pool(2);
    pipeline::StageContext context;
    context.workspace = path();
    context.output = path() / (std::string(stage.name()) + ".partial");
    std::filesystem::create_directories(context.output);
    context.pool = &pool;
    context.cancellation = &cancellation;
    context.progress = [](const Progress&) {};
    context.log = [this](pipeline::LogLevel level, const std::string& text) {
      (level == pipeline::LogLevel::kInfo ? infos : warnings).push_back(text);
    };
    infos.clear();
    warnings.clear();
    const Status status = stage.Run(context);
    summary = context.summary;
    if (status.ok()) {
      std::filesystem::remove_all(path() / stage.name());
      std::filesystem::rename(context.output, path() / stage.name());
    }
    return status;
  }

  const std::filesystem::path& path() const { return folder_.path(); }

  photos::PhotoList list;
  Status written;
  CancellationToken cancellation;
  std::vector<std::string> infos;
  std::vector<std::string> warnings;
  nlohmann::json summary;

 private:
  TemporaryFolder folder_;
};

}  // namespace freegs::stages

#endif  // FREEGS_TESTS_STAGES_SFM_WORKSPACE_H_
