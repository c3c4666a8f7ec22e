// SPDX-License-Identifier: BSD-3-Clause

#include "stages/ingest/ingest_stage.h"

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "photos/photo_decode.h"
#include "photos/photo_list.h"
#include "tests/shared_data.h"
#include "tests/stages/ingest_test_fixture.h"
#include "tests/unprivileged.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using photos::Photo;
using photos::PhotoSplit;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

using IngestStageTest = IngestTestFixture;

TEST_F(IngestStageTest, PlainPhotosAreCopiedByteForByte) {
  WritePhotos(12);
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(warnings_, IsEmpty());
  EXPECT_THAT(Files(PhotoSplit::kHoldout), ElementsAre("img0.jpg", "img8.jpg"));
  EXPECT_EQ(Written().size(), 12U);
  for (int i = 0; i < 12; ++i) {
    const std::string name = "img" + std::to_string(i) + ".jpg";
    const fs::path copy = workspace_.path() / "ingest.partial/photos" / name;
    EXPECT_EQ(*ReadFile(copy), *ReadFile(images_.path() / name));
    // Not links: editing one leaves the other alone.
    EXPECT_EQ(fs::hard_link_count(copy), 1U);
  }
  EXPECT_FALSE(fs::exists(workspace_.path() / "ingest.partial/pending"));
  EXPECT_EQ(summary_["photos"], 12);
  EXPECT_EQ(summary_["train"], 10);
  EXPECT_EQ(summary_["holdout"], 2);
  EXPECT_EQ(summary_["camera_groups"], 1);
  EXPECT_EQ(List().photos[10].file, "img10.jpg");
  EXPECT_EQ(last_progress_.total, 12);
}

TEST_F(IngestStageTest, ForetellsFromTheHeadersOfThePhotos) {
  pipeline::SceneOutlook scene;
  const auto foretell = [&](int threads, bool done = false) {
    ThreadPool pool(threads);
    pipeline::StageContext context;
    context.workspace = workspace_.path();
    context.images = images_.path();
    context.pool = &pool;
    scene = {};
    return MakeIngestStage(options_)->Foretell(context, done, &scene);
  };
  EXPECT_FALSE(foretell(2).known());  // No photo yet.
  EXPECT_FALSE(foretell(2, true).known());
  WritePhotos(5);
  const pipeline::StageNeed some = foretell(2);
  EXPECT_EQ(scene.train.size(), 4u);
  ASSERT_EQ(scene.holdout.size(), 1u);
  EXPECT_EQ(scene.holdout[0].camera.width, 64);
  EXPECT_EQ(some.disk_bytes, scene.photo_bytes);
  EXPECT_GT(some.memory_bytes, pipeline::kProgramMemory);
  EXPECT_LT(foretell(1).memory_bytes, some.memory_bytes);

  // What ingest would refuse does not count; what it writes anew is larger.
  images_.Write("a.jpg", "no photo");
  images_.Write("b.png", photos::MakePng(8, 8, 1));
  EXPECT_EQ(foretell(2).disk_bytes, some.disk_bytes);
  EXPECT_EQ(scene.photos(), 5);
  images_.Write("large.jpg",
                photos::WithExif(photos::MakeJpeg(640, 480, 1),
                                 photos::MakeExif({.orientation = 6})));
  const pipeline::StageNeed more = foretell(1);
  EXPECT_GT(more.memory_bytes, some.memory_bytes);
  EXPECT_GT(more.disk_bytes, some.disk_bytes + 2 * 640 * 480 - 1);
  EXPECT_GT(more.seconds, some.seconds);
  // A file larger than a photo may be, whatever its header says.
  images_.Write("huge.jpg", photos::MakeJpeg(64, 48, 3));
  fs::resize_file(images_.path() / "huge.jpg", photos::kMaxPhotoFileBytes + 1);
  foretell(1);
  EXPECT_EQ(scene.photos(), 6);
  fs::remove(images_.path() / "huge.jpg");
  // A header behind much else.
  images_.Write("tail.tif",
                photos::Encode(".tif", photos::MakePicture(400, 300, 2)));
  foretell(1);
  EXPECT_EQ(scene.photos(), 7);
  options_.keep_sharpest = 0.5;
  foretell(1);
  EXPECT_EQ(scene.photos(), 4);

  // Once it is done, the photos are those of images.json.
  options_.keep_sharpest = 1;
  ASSERT_TRUE(Run().ok());
  fs::rename(workspace_.path() / "ingest.partial",
             workspace_.path() / "ingest");
  images_.Write("later.jpg", photos::MakeJpeg(64, 48, 99));
  EXPECT_TRUE(foretell(1, true).known());
  EXPECT_EQ(scene.photos(), 7);
}

TEST_F(IngestStageTest, OfFilmsNothingIsForetold) {
  images_.Write("a.mp4", "film");
  ThreadPool pool(1);
  pipeline::StageContext context;
  context.images = images_.path();
  context.pool = &pool;
  pipeline::SceneOutlook scene;
  const pipeline::StageNeed need =
      MakeIngestStage(options_)->Foretell(context, false, &scene);
  EXPECT_FALSE(need.known());
  EXPECT_THAT(need.unknown_reason, HasSubstr("film"));
  EXPECT_EQ(need.advice, "");
  EXPECT_EQ(scene.photos(), 0);
}

TEST_F(IngestStageTest, OthersAreRewrittenUprightAndLossless) {
  const cv::Mat picture = photos::MakePicture(64, 48, 7);
  const std::string exif =
      photos::MakeExif({.orientation = 6, .model = "M", .focal_35mm = 30});
  images_.Write(
      "a.png",
      photos::WithPngChunk(photos::Encode(".png", picture), "eXIf", exif));
  images_.Write("b.tif",
                photos::Encode(".tif", photos::MakePicture(64, 48, 8)));
  images_.Write("c/b.jpg", photos::MakeJpeg(40, 40, 9));
  images_.Write("d d.png", photos::MakePng(50, 40, 10));
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(Written(), ElementsAre("a.png", "b.png", "c/b.jpg", "d_d.png"));
  const auto upright =
      ReadRgb(workspace_.path() / "ingest.partial/photos/a.png");
  ASSERT_TRUE(upright.ok());
  ASSERT_EQ(upright->width(), 48);
  ASSERT_EQ(upright->height(), 64);
  // Orientation 6: the stored left column, read upwards, is the top row.
  EXPECT_EQ((*upright)(0, 0, 2), picture.at<cv::Vec3b>(47, 0)[0]);
  EXPECT_EQ((*upright)(47, 0, 0), picture.at<cv::Vec3b>(0, 0)[2]);
  const photos::PhotoList list = List();
  EXPECT_EQ(list.photos[0].width, 48);
  EXPECT_EQ(list.photos[0].orientation, 6);
  EXPECT_TRUE(list.photos[0].converted);
  EXPECT_TRUE(list.photos[0].focal_length_px.has_value());
  EXPECT_EQ(list.photos[2].file, "c/b.jpg");
  EXPECT_EQ(summary_["camera_groups"], 4);
}

TEST_F(IngestStageTest, DuplicatesByContent) {
  WritePhotos(3);
  const cv::Mat picture = photos::MakePicture(64, 48, 7);
  images_.Write("copy.png", photos::Encode(".png", picture));
  images_.Write("copy of copy.tif", photos::Encode(".tif", picture));
  images_.Write("other.jpg", *ReadFile(images_.path() / "img1.jpg"));
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(Files(PhotoSplit::kRejected),
              ElementsAre("copy of copy.tif", "other.jpg"));
  EXPECT_THAT(
      warnings_,
      ElementsAre(
          HasSubstr("copy of copy.tif: not used: duplicate of copy.png"),
          HasSubstr("other.jpg: not used: duplicate of img1.jpg")));
}

// Everything that is wrong with somebody's photo folder, at once.
TEST_F(IngestStageTest, HostileFolder) {
  const std::string jpeg = photos::MakeJpeg(64, 48, 1);
  const fs::path root = images_.path();
  images_.Write("truncated.jpg", jpeg.substr(0, jpeg.size() / 2));
  images_.Write("text.jpg", "this is a text renamed to a photo\n");
  images_.Write("empty.jpg", "");
  images_.Write("pixel.png", photos::MakePng(1, 1, 1));
  images_.Write("lie_40000x1.jpg", photos::WithJpegSize(jpeg, 40000, 1));
  images_.Write("lie_60000x60000.jpg",
                photos::WithJpegSize(jpeg, 60000, 60000));
  images_.Write("lie.png",
                photos::WithPngSize(photos::MakePng(64, 48, 1), 20000, 19000));
  images_.Write("phone.heic", std::string("\0\0\0\x18", 4) + "ftypheic");
  images_.Write("notes.txt", "not a photo, and not called one");
  images_.Write(".hidden.jpg", "junk");
  images_.Write("with space.jpg", photos::MakeJpeg(64, 48, 2));
  images_.Write("it's \"quoted\".jpg", photos::MakeJpeg(64, 48, 3));
  images_.Write("größe 日本.png", photos::MakePng(64, 48, 4));
  images_.Write("new\nline.jpg", photos::MakeJpeg(64, 48, 5));
  images_.Write("nested/deeper/photo.jpg", photos::MakeJpeg(64, 48, 6));
  images_.Write("bytes\xff\xfe.jpg", photos::MakeJpeg(64, 48, 7));
  images_.Write("$(reboot); rm -rf.jpg", photos::MakeJpeg(64, 48, 8));
  fs::create_directory_symlink(root, root / "nested" / "loop");
  fs::create_directory_symlink("..", root / "nested" / "up");
  fs::create_symlink("nowhere.jpg", root / "broken.jpg");
  fs::create_symlink("self.jpg", root / "self.jpg");
  fs::create_directory(root / "folder.jpg");
  ASSERT_EQ(mkfifo((root / "pipe.jpg").c_str(), 0600), 0);
  images_.Write("secret.jpg", photos::MakeJpeg(64, 48, 9));
  ASSERT_EQ(chmod((root / "secret.jpg").c_str(), 0), 0);

  Status status;
  {
    const Unprivileged user({root, workspace_.path()});
    if (!user.works()) GTEST_SKIP() << "no other user may look in here";
    status = Run();
  }
  ASSERT_TRUE(status.ok()) << status.message();

  const struct {
    const char* file;
    const char* reason;
  } rejected[] = {
      {"broken.jpg", "no such file"},
      {"empty.jpg", "empty file (0 bytes)"},
      {"lie.png", "more than its data can hold"},
      {"lie_40000x1.jpg", "only 40000 x 1 pixels"},
      {"lie_60000x60000.jpg", "more than the limit of 400 megapixels"},
      {"phone.heic", "a HEIC file"},
      {"pipe.jpg", "not a regular file"},
      {"pixel.png", "only 1 x 1 pixels"},
      {"secret.jpg", "Permission denied"},
      {"self.jpg", ""},
      {"text.jpg", "not an image, whatever its name says"},
      {"truncated.jpg", "truncated JPEG"},
  };
  const photos::PhotoList list = List();
  EXPECT_EQ(list.Count(PhotoSplit::kRejected), std::size(rejected));
  for (const auto& expected : rejected) {
    const auto found = std::find_if(
        list.photos.begin(), list.photos.end(), [&](const Photo& photo) {
          return photo.file == expected.file;
        });
    ASSERT_NE(found, list.photos.end()) << expected.file;
    EXPECT_EQ(found->split, PhotoSplit::kRejected) << expected.file;
    EXPECT_THAT(found->reason, HasSubstr(expected.reason));
    EXPECT_THAT(warnings_,
                testing::Contains(testing::AllOf(
                    testing::StartsWith(expected.file), HasSubstr(";"))));
  }
  EXPECT_EQ(warnings_.size(), std::size(rejected));
  for (const std::string& warning : warnings_) {
    EXPECT_THAT(warning, Not(HasSubstr("\n")));
  }
  EXPECT_EQ(summary_["rejected"].size(), std::size(rejected));
  EXPECT_EQ(list.photos.size() - std::size(rejected), 7U);
  EXPECT_THAT(Written(),
              testing::UnorderedElementsAre("$(reboot);_rm_-rf.jpg",
                                            "bytes__.jpg",
                                            "größe_日本.png",
                                            "it's_\"quoted\".jpg",
                                            "nested/deeper/photo.jpg",
                                            "new_line.jpg",
                                            "with_space.jpg"));
  for (const std::string& name : Written()) {
    EXPECT_TRUE(
        ReadRgb(workspace_.path() / "ingest.partial/photos" / name).ok());
  }
}

TEST_F(IngestStageTest, FewerThanThreeUsablePhotos) {
  WritePhotos(2);
  images_.Write("bad.jpg", "");
  Status status = Run();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("2 of 3 photos can be used"));
  EXPECT_THAT(status.message(), HasSubstr("bad.jpg: empty file"));

  images_.Write("img2.jpg", photos::MakeJpeg(64, 48, 500));
  EXPECT_TRUE(Run().ok());
}

TEST_F(IngestStageTest, NoPhotosOrNoFolder) {
  images_.Write("notes.txt", "x");
  Status status = Run();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("no JPEG, PNG or TIFF photos"));

  pipeline::StageContext context;
  status = MakeIngestStage(options_)->Run(context);
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("no photo folder was given"));
}

TEST_F(IngestStageTest, SameResultForAnyThreadCountAndAfterLeftovers) {
  WritePhotos(9);
  images_.Write("turned.jpg",
                photos::WithExif(photos::MakeJpeg(64, 48, 50),
                                 photos::MakeExif({.orientation = 3})));
  ASSERT_TRUE(Run(1).ok());
  const fs::path output = workspace_.path() / "ingest.partial";
  const std::string json = *ReadFile(output / "images.json");
  const std::string turned = *ReadFile(output / "photos/turned.png");
  TemporaryFolder leftovers;
  fs::create_directories(output / "pending");
  fs::copy(output / "photos/img1.jpg", output / "photos/stale.jpg");
  ASSERT_TRUE(Run(4).ok());
  EXPECT_EQ(*ReadFile(output / "images.json"), json);
  EXPECT_EQ(*ReadFile(output / "photos/turned.png"), turned);
  EXPECT_EQ(Written().size(), 10U);
}

TEST_F(IngestStageTest, EqualPhotosFromElsewhereGiveTheSameList) {
  WritePhotos(3);
  const auto list_of = [&](const fs::path& source) {
    source_ = source;
    EXPECT_TRUE(Run().ok());
    EXPECT_EQ(List().images_folder, "photos");
    return ReadFile(workspace_.path() / "ingest.partial/images.json").value();
  };
  TemporaryFolder one;
  TemporaryFolder other;
  for (const TemporaryFolder* folder : {&one, &other}) {
    fs::copy(images_.path(), *folder / "photos", fs::copy_options::recursive);
  }
  const std::string list = list_of(one / "photos");
  EXPECT_EQ(list_of(other / "photos"), list);
  EXPECT_EQ(list_of(other / "photos" / ""), list);
}

TEST_F(IngestStageTest, HoldoutListAndPattern) {
  WritePhotos(6);
  options_.holdout = "img[45].jpg";
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(Files(PhotoSplit::kHoldout), ElementsAre("img4.jpg", "img5.jpg"));

  workspace_.Write("list.txt", "img2.jpg\nimg9.jpg\n");
  options_.holdout_list = (workspace_.path() / "list.txt").string();
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(Files(PhotoSplit::kHoldout), ElementsAre("img2.jpg"));
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("img9.jpg")));

  workspace_.Write("list.txt", "test_01.png\ntest_02.png\n");
  Status status = Run();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("test_01.png and test_02.png"));
  EXPECT_THAT(status.message(), HasSubstr("ingest.holdout_list"));

  options_.holdout_list = "no/such/list.txt";
  status = Run();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("ingest.holdout_list"));

  options_.holdout_list.clear();
  options_.holdout = "*";
  status = Run();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("ingest.holdout"));
}

TEST_F(IngestStageTest, KeepSharpest) {
  for (int i = 0; i < 12; ++i) {
    cv::Mat noise(96, 128, CV_8UC3);
    for (size_t k = 0; k < noise.total() * 3; ++k) {
      noise.data[k] = static_cast<uint8_t>(RandomIndex(i, 3, k, 256));
    }
    // Every third photo is sharper than its neighbours.
    if (i % 3 != 1) cv::GaussianBlur(noise, noise, {}, 2);
    images_.Write("f" + std::to_string(i) + ".png",
                  photos::Encode(".png", noise));
  }
  options_.keep_sharpest = 1.0 / 3;
  options_.holdout_every = 0;
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(Files(PhotoSplit::kTrain),
              ElementsAre("f1.png", "f4.png", "f7.png", "f10.png"));
  EXPECT_EQ(List().photos[0].reason, "blurrier than its neighbours");
  EXPECT_EQ(Written().size(), 4U);
}

TEST_F(IngestStageTest, CancellationStops) {
  WritePhotos(8);
  on_progress_ = [this] { cancellation_.Cancel(); };
  EXPECT_EQ(Run(1).code(), StatusCode::kInterrupted);
  EXPECT_FALSE(fs::exists(workspace_.path() / "ingest.partial/images.json"));
}

TEST_F(IngestStageTest, InputsAreThePhotosAndTheList) {
  WritePhotos(3);
  TemporaryFolder elsewhere;
  elsewhere.Write("x.jpg", photos::MakeJpeg(64, 48, 77));
  fs::create_directory_symlink(elsewhere.path(), images_.path() / "linked");
  options_.holdout_list = "list.txt";
  pipeline::StageContext context;
  context.images = images_.path();
  context.workspace = workspace_.path();
  EXPECT_THAT(MakeIngestStage(options_)->Inputs(context),
              ElementsAre(images_.path(),
                          fs::path("list.txt"),
                          images_.path() / "linked" / ""));
}

TEST_F(IngestStageTest, ALinkToAFolderThatHoldsTheWorkspaceIsRefused) {
  const TemporaryFolder folder;
  for (int i = 0; i < 4; ++i) {
    folder.Write("photos/" + std::to_string(i) + ".jpg",
                 photos::MakeJpeg(64, 48, i));
  }
  folder.Write("more/w/log.txt", "");
  folder.Write("more/set/4.jpg", photos::MakeJpeg(64, 48, 4));
  ThreadPool pool(1);
  pipeline::StageContext context;
  context.workspace = folder / "more/w";
  context.output = folder / "more/w/ingest.partial";
  context.images = folder / "photos";
  context.pool = &pool;
  context.cancellation = &cancellation_;
  context.progress = [](const Progress&) {};
  context.log = [](pipeline::LogLevel, const std::string&) {};
  const fs::path link = folder / "photos/linked";
  fs::create_directory_symlink("../more", link);
  const auto stage = MakeIngestStage(options_);
  const Status status = stage->Run(context);
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(),
              HasSubstr(link.string() + ": this link leads to"));
  EXPECT_THAT(status.message(), HasSubstr("which holds the workspace"));
  // What would change is not read as an input.
  EXPECT_THAT(stage->Inputs(context), ElementsAre(context.images));
  fs::remove(link);
  fs::create_directories(folder / "more/w/ingest/photos");
  fs::create_directory_symlink("../more/w/ingest/photos", link);
  EXPECT_THAT(stage->Run(context).message(),
              HasSubstr("which lies in the workspace"));
  // A folder beside the workspace is as good as any.
  fs::remove(link);
  fs::create_directory_symlink("../more/set", link);
  const Status beside = stage->Run(context);
  EXPECT_TRUE(beside.ok()) << beside.message();
}

TEST_F(IngestStageTest, RealPhotographs) {
  const fs::path folder = SharedData(fs::path("fox") / "images");
  if (folder.empty()) GTEST_SKIP() << "FREEGS_SHARED_DATA has no fox";
  for (const auto& entry : fs::directory_iterator(folder)) {
    images_.Write(entry.path().filename(), *ReadFile(entry.path()));
  }
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(warnings_, IsEmpty());
  EXPECT_EQ(summary_["photos"], 50);
  EXPECT_EQ(summary_["holdout"], 7);
  EXPECT_EQ(Written().size(), 50U);
}

TEST(IngestStageOptionsTest, DefaultsAreInRange) {
  IngestStageOptions options;
  EXPECT_TRUE(options.Check().ok());
  pipeline::OptionTable table;
  RegisterIngestOptions(options, table);
  EXPECT_TRUE(table.Check().ok());
  options.decode.min_side = 0;
  EXPECT_FALSE(options.Check().ok());
  options.decode.min_side = 32;
  options.keep_sharpest = 0;
  EXPECT_FALSE(options.Check().ok());
  options.keep_sharpest = 1;
  options.holdout_every = -1;
  EXPECT_FALSE(options.Check().ok());
}

// The position in a photo changes nothing but the file.
TEST_F(IngestStageTest, PositionsAreIgnoredAndFocalLengthsKept) {
  for (int i = 0; i < 3; ++i) {
    const std::string jpeg = photos::MakeJpeg(64, 48, 20 + i);
    const photos::ExifFields plain = {.model = "M", .focal_35mm = 26};
    photos::ExifFields gps = plain;
    gps.gps = true;
    images_.Write("plain" + std::to_string(i) + ".jpg",
                  photos::WithExif(jpeg, photos::MakeExif(plain)));
    images_.Write("a/gps" + std::to_string(i) + ".jpg",
                  photos::WithExif(photos::MakeJpeg(64, 48, 30 + i),
                                   photos::MakeExif(gps, i % 2 == 0)));
  }
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(warnings_, IsEmpty());
  const photos::PhotoList list = List();
  ASSERT_EQ(list.photos.size(), 6U);
  for (const Photo& photo : list.photos) {
    ASSERT_TRUE(photo.focal_length_px.has_value()) << photo.file;
    EXPECT_DOUBLE_EQ(*photo.focal_length_px, *list.photos[0].focal_length_px);
    EXPECT_EQ(photo.camera_group, 0);
  }
  const std::string json =
      *ReadFile(workspace_.path() / "ingest.partial/images.json");
  for (const char* word : {"latitude", "longitude", "altitude", "position"}) {
    EXPECT_THAT(json, Not(HasSubstr(word)));
  }
}

}  // namespace
}  // namespace freegs::stages
