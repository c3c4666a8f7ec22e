// SPDX-License-Identifier: BSD-3-Clause
// Gives a photo of a workspace another name.

#ifndef FREEGS_TESTS_STAGES_RENAMED_PHOTO_H_
#define FREEGS_TESTS_STAGES_RENAMED_PHOTO_H_

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "photos/photo_list.h"
#include "sfm/scene/model_io.h"

namespace freegs::stages {

// In ingest/images.json, undistort/sparse and undistort/images. The file keeps
// its content, whatever the suffix of the new name.
inline void RenamePhoto(const std::filesystem::path& workspace,
                        const std::string& name,
                        const std::string& new_name) {
  const std::filesystem::path list = workspace / "ingest" / "images.json";
  StatusOr<photos::PhotoList> photos = photos::ReadPhotoList(list);
  ASSERT_TRUE(photos.ok()) << photos.status().message();
  for (photos::Photo& photo : photos->photos) {
    if (photo.name == name) photo.file = photo.name = new_name;
  }
  ASSERT_TRUE(photos::WritePhotoList(list, *photos).ok());
  const std::filesystem::path folder = workspace / "undistort" / "sparse";
  StatusOr<sfm::Reconstruction> sparse = sfm::ReadModel(folder);
  ASSERT_TRUE(sparse.ok()) << sparse.status().message();
  for (sfm::PosedImage& image : sparse->images) {
    if (image.name == name) image.name = new_name;
  }
  ASSERT_TRUE(sfm::WriteModel(folder, *sparse).ok());
  const std::filesystem::path images = workspace / "undistort" / "images";
  std::filesystem::rename(images / name, images / new_name);
}

}  // namespace freegs::stages

#endif  // FREEGS_TESTS_STAGES_RENAMED_PHOTO_H_
