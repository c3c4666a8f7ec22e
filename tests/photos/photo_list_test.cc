// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_list.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/random.h"
#include "tests/photos/photo_test_files.h"

namespace freegs::photos {
namespace {

using nlohmann::json;
using testing::HasSubstr;

PhotoList MakeList() {
  PhotoList list;
  list.images_folder = "my photos/";
  Photo a;
  a.file = "a b.jpg";
  a.name = "a_b.jpg";
  a.format = "JPEG";
  a.width = 400;
  a.height = 300;
  a.orientation = 6;
  a.converted = true;
  a.sharpness = 12.25;
  a.hash = "00ff";
  a.file_hash = "11ee";
  a.camera_group = 0;
  a.make = "Maker";
  a.model = "Model";
  a.focal_length_mm = 4.2;
  a.focal_length_35mm = 26;
  a.focal_length_px = 290.5;
  Photo b = a;
  b.file = b.name = "sub/ü.png";
  b.split = PhotoSplit::kHoldout;
  b.focal_length_px.reset();
  b.digital_zoom = 1.5;
  Photo c;
  c.file = "bad.jpg";
  c.split = PhotoSplit::kRejected;
  c.reason = "empty file";
  list.photos = {a, b, c};
  return list;
}

// The list as JSON, to be damaged.
json MakeJson() {
  const TemporaryFolder folder;
  EXPECT_TRUE(WritePhotoList(folder.path() / "images.json", MakeList()).ok());
  return json::parse(*ReadFile(folder.path() / "images.json"));
}

std::string Fault(const std::string& text) {
  const auto list = ParsePhotoList(text, "images.json");
  if (list.ok()) return "read";
  EXPECT_EQ(list.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(list.status().message(), HasSubstr("images.json"));
  return list.status().message();
}

TEST(PhotoListTest, RoundTrip) {
  const TemporaryFolder folder;
  const PhotoList written = MakeList();
  ASSERT_TRUE(WritePhotoList(folder.path() / "images.json", written).ok());
  const auto read = ReadPhotoList(folder.path() / "images.json");
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->images_folder, written.images_folder);
  ASSERT_EQ(read->photos.size(), written.photos.size());
  for (size_t i = 0; i < written.photos.size(); ++i) {
    const Photo& a = written.photos[i];
    const Photo& b = read->photos[i];
    EXPECT_EQ(a.file, b.file);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.format, b.format);
    EXPECT_EQ(a.converted, b.converted);
    EXPECT_EQ(a.width, b.width);
    EXPECT_EQ(a.height, b.height);
    EXPECT_EQ(a.orientation, b.orientation);
    EXPECT_EQ(a.sharpness, b.sharpness);
    EXPECT_EQ(a.hash, b.hash);
    EXPECT_EQ(a.file_hash, b.file_hash);
    EXPECT_EQ(a.camera_group, b.camera_group);
    EXPECT_EQ(a.make, b.make);
    EXPECT_EQ(a.model, b.model);
    EXPECT_EQ(a.focal_length_mm, b.focal_length_mm);
    EXPECT_EQ(a.focal_length_35mm, b.focal_length_35mm);
    EXPECT_EQ(a.digital_zoom, b.digital_zoom);
    EXPECT_EQ(a.focal_length_px, b.focal_length_px);
    EXPECT_EQ(a.split, b.split);
    EXPECT_EQ(a.reason, b.reason);
  }
  const json document = MakeJson();
  EXPECT_EQ(document["version"], 1);
  EXPECT_EQ(document["counts"]["train"], 1);
  EXPECT_EQ(document["counts"]["holdout"], 1);
  EXPECT_EQ(document["counts"]["rejected"], 1);
}

TEST(PhotoListTest, NamesThatAreNotUtf8CanBeWritten) {
  const TemporaryFolder folder;
  PhotoList list = MakeList();
  list.photos[0].file = "\xff\xfe.jpg";
  ASSERT_TRUE(WritePhotoList(folder.path() / "images.json", list).ok());
  EXPECT_TRUE(ReadPhotoList(folder.path() / "images.json").ok());
}

TEST(PhotoListTest, FaultsAreNamed) {
  const struct {
    const char* pointer;
    json value;
    const char* message;
  } cases[] = {
      {"/version", 2, "version: is 2 instead of 1"},
      {"/version", "1", "version: must be a whole number in 0..1073741824"},
      {"/photos", json::object(), "photos: must be a list"},
      {"/photos/0", 7, "photos[0]: must be an object"},
      {"/photos/0/file", nullptr, "photos[0].file: must be a text"},
      {"/photos/0/width", 0, "photos[0].width: is 0"},
      {"/photos/0/width", -5, "0..1048576"},
      {"/photos/0/width", 1e9, "0..1048576"},
      {"/photos/0/width", 18446744073709551615U, "0..1048576"},
      {"/photos/0/height", "300", "a whole number"},
      {"/photos/0/orientation", 9, "1..8"},
      {"/photos/0/sharpness", nullptr, "must be a number"},
      {"/photos/0/sharpness", 1e300, "0..1e+12"},
      {"/photos/0/sharpness", -1, "0..1e+12"},
      {"/photos/0/camera_group", -1, "camera_group: is negative"},
      {"/photos/0/focal_length_px", "wide", "must be a number"},
      {"/photos/0/converted", 1, "must be true or false"},
      {"/photos/0/split", "test", "split"},
      {"/photos/0/name", "", "name: is not the name"},
      {"/photos/0/name", "../outside.jpg", "name: is not the name"},
      {"/photos/0/name", "a/../../b.jpg", "name: is not the name"},
      {"/photos/0/name", "/etc/passwd", "name: is not the name"},
      {"/photos/0/name", "folder/", "name: is not the name"},
      {"/photos/0/name", std::string("a\0b", 3), "name: is not the name"},
      {"/photos/0/name", "sub/ü.png", "name: is used twice"},
  };
  for (const auto& c : cases) {
    json document = MakeJson();
    document[json::json_pointer(c.pointer)] = c.value;
    EXPECT_THAT(Fault(document.dump()), HasSubstr(c.message)) << c.pointer;
  }
}

TEST(PhotoListTest, EveryFieldIsNeeded) {
  const json document = MakeJson();
  for (const auto& [key, value] : document["photos"][0].items()) {
    json damaged = document;
    damaged["photos"][0].erase(key);
    EXPECT_THAT(Fault(damaged.dump()), HasSubstr(key + ": is missing"));
  }
}

TEST(PhotoListTest, HostileText) {
  const std::string good = MakeJson().dump();
  EXPECT_EQ(Fault(good), "read");
  for (size_t size = 0; size < good.size(); ++size) {
    EXPECT_NE(Fault(good.substr(0, size)), "read") << size;
  }
  EXPECT_THAT(Fault(std::string(2'000'000, '[')), HasSubstr("nested deeper"));
  const std::string deep =
      std::string(200'000, '[') + std::string(200'000, ']');
  EXPECT_THAT(Fault(deep), HasSubstr("images.json"));
  EXPECT_THAT(
      Fault(R"({"version":1,"images_folder":"","photos":)" + deep + "}"),
      HasSubstr("nested deeper"));
  EXPECT_THAT(Fault("[]"), HasSubstr("must be an object"));
  EXPECT_THAT(Fault("null"), HasSubstr("must be an object"));
  EXPECT_THAT(Fault(R"({"version":1e999})"), HasSubstr("images.json"));
  for (uint64_t trial = 0; trial < 2000; ++trial) {
    std::string text = good;
    text[RandomIndex(3, trial, 0, text.size())] =
        static_cast<char>(RandomBits(3, trial, 1));
    (void)ParsePhotoList(text, "images.json");
  }
}

TEST(PhotoListTest, MissingFile) {
  const TemporaryFolder folder;
  EXPECT_EQ(ReadPhotoList(folder.path() / "none.json").status().code(),
            StatusCode::kBadInput);
}

}  // namespace
}  // namespace freegs::photos
