// SPDX-License-Identifier: BSD-3-Clause

#include "stages/datasets/mask_folders.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pair;

TEST(MaskFoldersTest, ListsFoldersAndPhrasesByName) {
  const TemporaryFolder folder;
  for (const char* file : {"b/two.png",
                           "b/red cup.jpg",
                           "b/list.txt",
                           "a/x.PNG",
                           "c/notes.txt",
                           "beside.png"}) {
    folder.Write(file, "");
  }
  const auto folders = ListMaskFolders(folder.path());
  ASSERT_TRUE(folders.ok()) << folders.status().message();
  ASSERT_EQ(folders->size(), 2u);
  EXPECT_EQ((*folders)[0].name, "a");
  EXPECT_THAT((*folders)[0].masks, ElementsAre(Pair("x", folder / "a/x.PNG")));
  EXPECT_EQ((*folders)[1].name, "b");
  EXPECT_THAT((*folders)[1].masks,
              ElementsAre(Pair("red cup", folder / "b/red cup.jpg"),
                          Pair("two", folder / "b/two.png")));
}

TEST(MaskFoldersTest, RefusesFoldersWithoutMasksAndOddPhrases) {
  const TemporaryFolder folder;
  const auto fault = [&](const std::string& name) {
    const auto folders = ListMaskFolders(folder / name);
    EXPECT_EQ(folders.status().code(), StatusCode::kBadInput) << name;
    return folders.status().message();
  };
  EXPECT_THAT(fault("none"), HasSubstr("cannot be read"));
  folder.Write("empty/a/notes.txt", "");
  EXPECT_THAT(fault("empty"), HasSubstr("holds no folder with masks"));
  folder.Write("control/a/red\ncup.png", "");
  EXPECT_THAT(fault("control"), HasSubstr("no phrase"));
  folder.Write("long/a/" + std::string(201, 'x') + ".png", "");
  EXPECT_THAT(fault("long"), HasSubstr("no phrase"));
}

TEST(MaskFoldersTest, NumbersPhotosByTheirNamesUpToTheFirstDot) {
  const TemporaryFolder scene;
  for (const char* name : {"b.jpg", "a-2.jpg", "a.jpg", "list.txt"}) {
    scene.Write(std::string("images/") + name, "");
  }
  const auto photos = ReadDatasetPhotos(scene.path());
  ASSERT_TRUE(photos.ok()) << photos.status().message();
  EXPECT_THAT(photos->names, ElementsAre("a.jpg", "a-2.jpg", "b.jpg"));
  EXPECT_THAT(photos->views, IsEmpty());
  EXPECT_EQ(PhotoStem("left/a.b.jpg"), "a");
  EXPECT_THAT(FilesIn(scene / "images"),
              ElementsAre("a-2.jpg", "a.jpg", "b.jpg", "list.txt"));
  EXPECT_THAT(FilesIn(scene / "none"), IsEmpty());
  const auto none = ReadDatasetPhotos(scene / "images");
  EXPECT_EQ(none.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(none.status().message(), HasSubstr("neither a COLMAP model"));
}

TEST(MaskFoldersTest, EachPhraseIsAnObject) {
  DatasetPhotos photos;
  photos.names = {"a.jpg", "b.jpg"};
  const MaskFolder a = {"a", {{"cup", "a/cup.png"}}};
  const MaskFolder b = {"b", {{"apple", "b/apple.png"}, {"cup", "b/cup.png"}}};
  const auto truth = TruthOfMasks("scene", photos, {{1, b}, {0, a}});
  ASSERT_TRUE(truth.ok()) << truth.status().message();
  ASSERT_EQ(truth->objects.size(), 2u);
  EXPECT_EQ(truth->objects[0].id, 1);
  EXPECT_EQ(truth->objects[0].label, "apple");
  EXPECT_FALSE(truth->objects[0].aabb);
  EXPECT_EQ(truth->objects[1].label, "cup");
  // Without poses, the workspace is asked for those of the photographs.
  EXPECT_THAT(truth->unposed, ElementsAre("b.jpg", "a.jpg"));
  EXPECT_THAT(truth->cameras.test, IsEmpty());
  const std::vector<MaskFile>& masks = truth->masks.at("b.jpg");
  ASSERT_EQ(masks.size(), 2u);
  EXPECT_EQ(masks[1].path, "b/cup.png");
  EXPECT_EQ(masks[1].object, 2);
  ASSERT_EQ(truth->masks.at("a.jpg").size(), 1u);
  EXPECT_EQ(truth->masks.at("a.jpg")[0].object, 2);

  const MaskFolder twice = {"a", {{"cup", "a/cup.jpg"}, {"cup", "a/cup.png"}}};
  const auto refused = TruthOfMasks("scene", photos, {{0, twice}});
  EXPECT_EQ(refused.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(refused.status().message(),
              HasSubstr("a/cup.png: a second mask of \"cup\""));
}

}  // namespace
}  // namespace freegs::stages
