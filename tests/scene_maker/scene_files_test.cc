// SPDX-License-Identifier: BSD-3-Clause

#include "tests/scene_maker/scene_files.h"

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>

#include <Eigen/Core>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "tests/temporary_folder.h"

namespace freegs::scene_maker {
namespace {

namespace fs = std::filesystem;

TEST(EncodeNpzFloat16, HoldsTheValues) {
  ImageF values(3, 2, 1);
  for (int i = 0; i < 6; ++i) values.data()[i] = 0.25f * static_cast<float>(i);
  const std::string npz = EncodeNpzFloat16("depth", values);
  EXPECT_EQ(npz.substr(0, 4), std::string("PK\x03\x04", 4));
  EXPECT_EQ(npz.substr(30, 9), "depth.npy");
  const std::string npy = npz.substr(39);
  EXPECT_EQ(npy.substr(0, 6), "\x93NUMPY");
  uint16_t header = 0;
  std::memcpy(&header, npy.data() + 8, 2);
  EXPECT_EQ((10 + header) % 64, 0);
  EXPECT_NE(npy.find("'descr': '<f2'"), std::string::npos);
  EXPECT_NE(npy.find("'shape': (2, 3)"), std::string::npos);
  for (int i = 0; i < 6; ++i) {
    Eigen::half value;
    std::memcpy(&value, npy.data() + 10 + header + 2 * i, 2);
    EXPECT_EQ(static_cast<float>(value), values.data()[i]);
  }
  // The end record points at the central directory.
  uint32_t directory = 0;
  std::memcpy(&directory, npz.data() + npz.size() - 6, 4);
  EXPECT_EQ(npz.substr(directory, 4), std::string("PK\x01\x02", 4));
}

TEST(WriteScene, WritesTheLayout) {
  SceneMakerOptions options;
  options.views = 3;
  options.test_views = 1;
  options.width = 64;
  options.height = 48;
  options.objects = 4;
  const Scene scene = *BuildScene(options);
  const TemporaryFolder temporary;
  const fs::path folder = temporary / "scene";
  ThreadPool pool(2);
  int calls = 0;
  ASSERT_TRUE(WriteScene(scene, folder, pool, [&calls](int done, int total) {
                EXPECT_EQ(done, ++calls);
                EXPECT_EQ(total, 4);
              }).ok());
  EXPECT_EQ(calls, 4);
  for (const char* name : {"README.md",
                           "images/frame_0003.jpg",
                           "gt/cameras.json",
                           "gt/instance/frame_0001.png",
                           "gt/instance/test_01.png",
                           "gt/depth/test_01.npz",
                           "test/images/test_01.png",
                           "test/masks/test_01/green book.png",
                           "test/masks_background/test_01/table.png"}) {
    EXPECT_TRUE(fs::exists(folder / name)) << name;
  }
  const auto cameras =
      nlohmann::json::parse(*ReadFile(folder / "gt/cameras.json"));
  EXPECT_EQ(cameras["train"].size(), 3u);
  EXPECT_EQ(cameras["test"]["test_01.png"][3][3], 1.0);
  EXPECT_EQ(cameras["intrinsics"]["w"], 64);
  const auto objects =
      nlohmann::json::parse(*ReadFile(folder / "gt/objects.json"));
  EXPECT_EQ(objects["objects"].size(), 4u);
  EXPECT_EQ(objects["objects"][2]["label"], "green book");

  // What is there already is kept.
  EXPECT_EQ(WriteScene(scene, folder, pool).code(), StatusCode::kBadInput);
  fs::remove_all(folder / "images");
  EXPECT_EQ(WriteScene(scene, folder, pool).code(), StatusCode::kBadInput);
  EXPECT_FALSE(fs::exists(folder / "images"));

  // Masks are cut-outs of the instance map.
  const ImageU16 ids = *ReadLabels(folder / "gt/instance/test_01.png");
  const ImageU16 mask =
      *ReadLabels(folder / "test/masks/test_01/green book.png");
  for (size_t i = 0; i < ids.size(); ++i) {
    EXPECT_EQ(mask.data()[i], ids.data()[i] == 3 ? 255 : 0);
  }
}

}  // namespace
}  // namespace freegs::scene_maker
