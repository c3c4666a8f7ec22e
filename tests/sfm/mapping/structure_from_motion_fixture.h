// SPDX-License-Identifier: BSD-3-Clause
// Structure from motion of small equal photos, on a fake COLMAP.

#ifndef FREEGS_TESTS_SFM_MAPPING_STRUCTURE_FROM_MOTION_FIXTURE_H_
#define FREEGS_TESTS_SFM_MAPPING_STRUCTURE_FROM_MOTION_FIXTURE_H_

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sfm/mapping/structure_from_motion.h"
#include "tests/sfm/fake_colmap.h"
#include "tests/sfm/synthetic_model.h"
#include "tests/sfm/textured_photo.h"

namespace freegs::sfm {

using Settings = std::vector<std::pair<std::string, std::string>>;

class StructureFromMotionTest : public testing::Test {
 protected:
  StructureFromMotionTest() {
    input_.photo_folder = folder_ / "photos";
    input_.work_folder = folder_ / "work folder";
    TakePhotos(10);
  }

  void TakePhotos(int count) {
    input_.photos.clear();
    for (int i = 0; i < count; ++i) {
      SfmPhoto photo;
      photo.name = PhotoName(i);
      photo.width = 640;
      photo.height = 480;
      photo.camera_group = i < 7 ? 0 : 1;
      photo.focal_px = i < 7 ? 600 : 0;
      input_.photos.push_back(photo);
    }
    WriteTexturedPhotos(input_);
    options_.num_threads = 2;
  }

  StatusOr<SfmResult> Run(const Settings& settings = {}) {
    options_.colmap = MakeFakeColmap(folder_.path(), settings);
    return RunStructureFromMotion(input_, options_);
  }

  std::string Log(const std::string& command) const {
    return ReadText(input_.work_folder / "logs" / (command + ".log"));
  }

  TemporaryFolder folder_;
  SfmInput input_;
  SfmOptions options_;
};

inline std::vector<std::string> AttemptNames(
    const std::vector<Attempt>& attempts) {
  std::vector<std::string> names;
  for (const Attempt& attempt : attempts) names.push_back(attempt.name);
  return names;
}

}  // namespace freegs::sfm

#endif  // FREEGS_TESTS_SFM_MAPPING_STRUCTURE_FROM_MOTION_FIXTURE_H_
