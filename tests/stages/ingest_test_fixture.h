// SPDX-License-Identifier: BSD-3-Clause
// Runs the ingest stage on a folder that the test fills.

#ifndef FREEGS_TESTS_STAGES_INGEST_TEST_FIXTURE_H_
#define FREEGS_TESTS_STAGES_INGEST_TEST_FIXTURE_H_

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/parallel.h"
#include "photos/photo_list.h"
#include "stages/ingest/ingest_stage.h"
#include "tests/photos/photo_test_files.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {

class IngestTestFixture : public testing::Test {
 protected:
  Status Run(int threads = 2) {
    ThreadPool pool(threads);
    pipeline::StageContext context;
    context.workspace = workspace_.path();
    context.output = workspace_.path() / "ingest.partial";
    context.images = source_.empty() ? images_.path() : source_;
    context.pool = &pool;
    context.cancellation = &cancellation_;
    context.progress = [this](const Progress& progress) {
      last_progress_ = progress;
      if (on_progress_) on_progress_();
    };
    context.log = [this](pipeline::LogLevel level, const std::string& text) {
      if (level == pipeline::LogLevel::kWarning) warnings_.push_back(text);
    };
    warnings_.clear();
    const Status status = MakeIngestStage(options_)->Run(context);
    summary_ = context.summary;
    return status;
  }

  photos::PhotoList List() const {
    auto list =
        photos::ReadPhotoList(workspace_.path() / "ingest.partial/images.json");
    EXPECT_TRUE(list.ok()) << list.status().message();
    return list.ok() ? *std::move(list) : photos::PhotoList();
  }

  std::vector<std::string> Files(photos::PhotoSplit split) const {
    std::vector<std::string> files;
    for (const photos::Photo& photo : List().photos) {
      if (photo.split == split) files.push_back(photo.file);
    }
    return files;
  }

  // Everything below photos/, sorted.
  std::vector<std::string> Written() const {
    const std::filesystem::path folder =
        workspace_.path() / "ingest.partial" / "photos";
    std::vector<std::string> names;
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(folder)) {
      if (entry.is_regular_file()) {
        names.push_back(
            std::filesystem::relative(entry.path(), folder).string());
      }
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  void WritePhotos(int count) {
    for (int i = 0; i < count; ++i) {
      images_.Write("img" + std::to_string(i) + ".jpg",
                    photos::MakeJpeg(64, 48, 100 + i));
    }
  }

  IngestStageOptions options_;
  std::filesystem::path source_;  // Instead of images_.
  TemporaryFolder images_;
  TemporaryFolder workspace_;
  CancellationToken cancellation_;
  std::function<void()> on_progress_;
  Progress last_progress_;
  std::vector<std::string> warnings_;
  nlohmann::json summary_;
};

}  // namespace freegs::stages

#endif  // FREEGS_TESTS_STAGES_INGEST_TEST_FIXTURE_H_
