// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/render_command.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sfm/import/transforms_json.h"
#include "stages/scene/scene_instances.h"
#include "tests/stages/commands/render_fixture.h"
#include "tests/stages/moved_world.h"

namespace freegs::stages {
namespace {

using testing::HasSubstr;

class RenderCommandTest : public RenderFixture {};

TEST_F(RenderCommandTest, ColorIsTheRendererAtTrainingSize) {
  const Status status = Render({workspace(), "--out", out()});
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_THAT(output_.str(), HasSubstr("6 pictures"));
  for (const View& view : workspace_.views) {
    const auto picture = ReadRgb(out() + "/" + view.name);
    ASSERT_TRUE(picture.ok()) << picture.status().message();
    const Pinhole camera =
        view.camera.LimitedTo(SyntheticWorkspace::kTrainingSide);
    const ImageU8 expected = ToU8(splat::RenderView(workspace_.model,
                                                    camera,
                                                    view.cam_from_world,
                                                    WhiteBackground(),
                                                    pool_)
                                      .color);
    ASSERT_EQ(picture->size(), expected.size());
    for (size_t k = 0; k < expected.size(); ++k) {
      ASSERT_NEAR(picture->data()[k], expected.data()[k], 1);
    }
  }
}

TEST_F(RenderCommandTest, SamePicturesInAnyUnitAndDepthInIt) {
  RoundModel(workspace_.path());
  ASSERT_TRUE(Render({workspace(), "--out", out()}).ok());
  const std::string color = ReadText(out() + "/photo1.png");
  ASSERT_TRUE(Render({workspace(), "--out", out(), "--what", "depth"}).ok());
  const auto depth = nlohmann::json::parse(ReadText(out() + "/depth.json"));
  MoveWorld(workspace_.path(), 1000, {7000, 0, -2000});
  ASSERT_TRUE(Render({workspace(), "--out", out()}).ok());
  EXPECT_EQ(ReadText(out() + "/photo1.png"), color);
  ASSERT_TRUE(Render({workspace(), "--out", out(), "--what", "depth"}).ok());
  const auto larger = nlohmann::json::parse(ReadText(out() + "/depth.json"));
  for (const char* key : {"near", "far", "unit"}) {
    EXPECT_NEAR(larger[key].get<double>() / depth[key].get<double>(), 1000, 0.1)
        << key;
  }
}

// The names of views may have folders.
TEST_F(RenderCommandTest, NoPictureGoesWhereTheStagesRead) {
  const std::string file = (out_.path() / "cameras.json").string();
  WriteText(file, Cameras("undistort/images/", Sim3d()).dump());
  const Status status = Render(
      {workspace(), "--cameras", file, "--no-align", "--out", workspace()});
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << status.message();

  nlohmann::json cameras = Cameras("", Sim3d());
  cameras["train"]["preview/photo1.png"] = cameras["train"]["photo1.png"];
  WriteText(file, cameras.dump());
  const std::vector<std::string> words = {
      workspace(), "--cameras", file, "--no-align", "--out", out()};
  EXPECT_TRUE(Render(words).ok());
  std::vector<std::string> with_previews = words;
  with_previews.insert(with_previews.end(), {"--what", "depth"});
  const Status preview = Render(with_previews);
  EXPECT_EQ(preview.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(preview.message(), HasSubstr("preview of another"));
}

TEST_F(RenderCommandTest, SizeOverridesTrainingSize) {
  ASSERT_TRUE(Render({workspace(), "--out", out(), "--size", "48"}).ok());
  const auto picture = ReadRgb(out() + "/photo1.png");
  ASSERT_TRUE(picture.ok());
  EXPECT_EQ(picture->width(), 48);
  EXPECT_EQ(picture->height(), 36);
}

TEST_F(RenderCommandTest, DepthInUnitsOfItsScale) {
  ASSERT_TRUE(
      Render({workspace(), "--out", out(), "--what", "depth", "--size", "64"})
          .ok());
  const auto scale = nlohmann::json::parse(ReadText(out() + "/depth.json"));
  const double unit = scale["unit"].get<double>();
  EXPECT_NEAR(std::log10(unit), std::round(std::log10(unit)), 1e-9);
  const View& view = workspace_.views[2];
  const auto stored = ReadLabels(out() + "/" + view.name);
  ASSERT_TRUE(stored.ok());
  const ImageF depth = splat::RenderView(workspace_.model,
                                         view.camera,
                                         view.cam_from_world,
                                         WhiteBackground(),
                                         pool_)
                           .depth;
  ASSERT_EQ(stored->size(), depth.size());
  for (size_t k = 0; k < depth.size(); ++k) {
    ASSERT_NEAR(stored->data()[k] * unit, depth.data()[k], 3 * unit);
  }
  EXPECT_TRUE(ReadRgb(out() + "/preview/" + view.name).ok());
}

TEST_F(RenderCommandTest, InstancesAreIds) {
  workspace_.AddInstances();
  const Status status =
      Render({workspace(), "--out", out(), "--what", "instances"});
  ASSERT_TRUE(status.ok()) << status.message();
  const View& view = workspace_.views[1];
  const auto stored = ReadLabels(out() + "/" + view.name);
  ASSERT_TRUE(stored.ok());
  const Image<int32_t> labels = splat::RenderLabels(
      workspace_.model,
      view.camera.LimitedTo(SyntheticWorkspace::kTrainingSide),
      view.cam_from_world,
      WhiteBackground(),
      pool_,
      workspace_.labels);
  ASSERT_EQ(stored->size(), labels.size());
  int found = 0;
  int different = 0;
  for (size_t k = 0; k < labels.size(); ++k) {
    different += stored->data()[k] != labels.data()[k] + 1;
    found += labels.data()[k] >= 0;
  }
  EXPECT_GT(found, 100);
  // Positions are rounded when they are read.
  EXPECT_LE(different, 2);
  EXPECT_TRUE(ReadRgb(out() + "/preview/" + view.name).ok());
}

TEST_F(RenderCommandTest, WithoutInstancesSaysWhatToRun) {
  const Status status =
      Render({workspace(), "--out", out(), "--what", "instances"});
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("run stage bootstrap"));
}

TEST_F(RenderCommandTest, InstancesOfAnotherModelAreRefused) {
  workspace_.AddInstances();
  semantics::Idsf other;
  other.instances = {0, 1, 2};
  ASSERT_TRUE(
      semantics::WriteIdsf(workspace_ / "bootstrap" / "idsf.bin", other).ok());
  const Status status =
      Render({workspace(), "--out", out(), "--what", "instances"});
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("3 Gaussians, not 120"));
}

TEST_F(RenderCommandTest, CameraFileOfAnotherWorldIsAligned) {
  WriteText(out_ / "cameras.json", MovedCameras("").dump());
  const Status status = Render({workspace(),
                                "--out",
                                out(),
                                "--cameras",
                                (out_ / "cameras.json").string()});
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_THAT(output_.str(), HasSubstr("7 pictures"));
  const View& view = workspace_.views[3];
  const auto picture = ReadRgb(out() + "/new.png");
  ASSERT_TRUE(picture.ok());
  const ImageU8 expected = ToU8(splat::RenderView(workspace_.model,
                                                  view.camera,
                                                  view.cam_from_world,
                                                  WhiteBackground(),
                                                  pool_)
                                    .color);
  ASSERT_EQ(picture->size(), expected.size());
  for (size_t k = 0; k < expected.size(); ++k) {
    ASSERT_NEAR(picture->data()[k], expected.data()[k], 1);
  }
}

// Depth and rendered_cameras.json are in the world of the camera file.
TEST_F(RenderCommandTest, OutputsOfAnAlignedCameraFileAreInItsWorld) {
  const Sim3d moved{.scale = 7, .translation = {3, 0, -1}};
  WriteText(out_ / "cameras.json", Cameras("", moved).dump());
  const std::vector<std::string> depth = {
      workspace(), "--what", "depth", "--size", "64", "--out", out()};
  ASSERT_TRUE(Render(depth).ok());
  const auto json_of = [&](const std::string& name) {
    return nlohmann::json::parse(ReadText(out() + "/" + name));
  };
  const double far = json_of("depth.json")["far"].get<double>();
  const auto frames = json_of("rendered_cameras.json")["frames"];
  std::vector<std::string> words = depth;
  words.insert(words.end(), {"--cameras", (out_ / "cameras.json").string()});
  ASSERT_TRUE(Render(words).ok()) << output_.str();
  EXPECT_NEAR(json_of("depth.json")["far"].get<double>(), 7 * far, 0.01 * far);
  const auto moved_frames = json_of("rendered_cameras.json")["frames"];
  ASSERT_EQ(moved_frames.size(), frames.size() + 1);  // And new.png.
  const auto centre = [](const nlohmann::json& frame) {
    const nlohmann::json& m = frame["transform_matrix"];
    return Eigen::Vector3d(
        m[0][3].get<double>(), m[1][3].get<double>(), m[2][3].get<double>());
  };
  for (size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(moved_frames[i]["file_path"], frames[i]["file_path"]);
    EXPECT_LT((centre(moved_frames[i]) - moved * centre(frames[i])).norm(),
              1e-4);
  }
  // The program reads the file, with the intrinsics of the pictures.
  const auto file =
      sfm::ParseTransforms(ReadText(out() + "/rendered_cameras.json"));
  ASSERT_TRUE(file.ok()) << file.status().message();
  EXPECT_EQ(file->frames[0].intrinsics.width, 64);
  const std::string before = ReadText(out() + "/photo1.png");
  ASSERT_TRUE(Render({workspace(),
                      "--what",
                      "depth",
                      "--out",
                      out(),
                      "--cameras",
                      out() + "/rendered_cameras.json"})
                  .ok());
  EXPECT_EQ(ReadText(out() + "/photo1.png"), before);
}

TEST_F(RenderCommandTest, DepthWithAnotherUnitNeedsAnotherFolder) {
  ASSERT_TRUE(Render({workspace(), "--what", "depth", "--out", out()}).ok());
  WriteText(out_ / "cameras.json", Cameras("", {.scale = 1e4}).dump());
  const std::string before = ReadText(out() + "/depth.json");
  const std::vector<std::string> all = {workspace(),
                                        "--what",
                                        "depth",
                                        "--out",
                                        out(),
                                        "--cameras",
                                        (out_ / "cameras.json").string()};
  // All pictures of the first call are replaced.
  EXPECT_TRUE(Render(all).ok()) << output_.str();
  EXPECT_NE(ReadText(out() + "/depth.json"), before);
  // Here the one that only the file has would stay.
  const Status status =
      Render({workspace(), "--what", "depth", "--out", out()});
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("another unit, such as new.png"));
}

TEST_F(RenderCommandTest, AnyDepthFileOfSomebodyElseIsReplaced) {
  ASSERT_TRUE(Render({workspace(), "--what", "depth", "--out", out()}).ok());
  const std::string expected = ReadText(out() + "/depth.json");
  for (const char* found : {R"({"unit": "mm", "pictures": ["photo1.png", 3]})",
                            R"({"pictures": {"a": 1}})",
                            "[1]",
                            "{"}) {
    WriteText(out() + "/depth.json", found);
    EXPECT_TRUE(Render({workspace(), "--what", "depth", "--out", out()}).ok());
    EXPECT_EQ(ReadText(out() + "/depth.json"), expected) << found;
  }
}

TEST_F(RenderCommandTest, ObjectsMayBeOutOfSight) {
  workspace_.AddInstances();
  nlohmann::json cameras = MovedCameras("other_");
  WriteText(out_ / "cameras.json", cameras.dump());
  EXPECT_TRUE(Render({workspace(),
                      "--out",
                      out(),
                      "--cameras",
                      (out_ / "cameras.json").string(),
                      "--no-align",
                      "--only",
                      "1"})
                  .ok());
  EXPECT_THAT(messages_.str(), HasSubstr("none of the views shows anything"));
  const auto picture = ReadRgb(out() + "/new.png");
  ASSERT_TRUE(picture.ok());
  EXPECT_TRUE(std::all_of(picture->data(),
                          picture->data() + picture->size(),
                          [](uint8_t value) { return value == 255; }));
}

TEST_F(RenderCommandTest, CameraFileOfOtherPhotosNeedsNoAlign) {
  WriteText(out_ / "cameras.json", MovedCameras("other_").dump());
  const std::string file = (out_ / "cameras.json").string();
  const Status status =
      Render({workspace(), "--out", out(), "--cameras", file});
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("--no-align"));
  // Where these cameras look, nothing is.
  const std::vector<std::string> no_align = {
      workspace(), "--out", out(), "--cameras", file, "--no-align"};
  EXPECT_EQ(Render(no_align).code(), StatusCode::kUnusableResult);
  WriteText(out_ / "cameras.json", Cameras("other_", {}).dump());
  EXPECT_TRUE(Render(no_align).ok());
}

TEST_F(RenderCommandTest, OneNameInBothSectionsOfACameraFileIsRefused) {
  nlohmann::json cameras = Cameras("", {});
  const std::string name = workspace_.views[2].name;
  cameras["test"][name] = cameras["train"][name];
  WriteText(out_ / "cameras.json", cameras.dump());
  const Status status = Render({workspace(),
                                "--out",
                                out(),
                                "--cameras",
                                (out_ / "cameras.json").string()});
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("view \"" + name + "\""));
}

TEST_F(RenderCommandTest, HugePicturesNeedASize) {
  nlohmann::json cameras = MovedCameras("");
  cameras["intrinsics"]["w"] = 60000;
  cameras["intrinsics"]["h"] = 40000;
  cameras["intrinsics"]["fx"] = 50000;
  cameras["intrinsics"]["fy"] = 50000;
  WriteText(out_ / "cameras.json", cameras.dump());
  std::vector<std::string> arguments = {workspace(),
                                        "--out",
                                        out(),
                                        "--cameras",
                                        (out_ / "cameras.json").string()};
  const Status status = Render(arguments);
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("--size"));
  arguments.insert(arguments.end(), {"--size", "60"});
  EXPECT_TRUE(Render(arguments).ok());
}

TEST_F(RenderCommandTest, SemanticsHaveOneColourPerMeaning) {
  workspace_.AddInstances();
  // Without vectors.
  const Status none =
      Render({workspace(), "--out", out(), "--what", "semantics"});
  EXPECT_EQ(none.code(), StatusCode::kBadInput);
  EXPECT_THAT(none.message(), HasSubstr("no semantic vectors"));

  // All of an instance has one colour; black would be nothing known.
  semantics::Idsf idsf;
  idsf.instances = workspace_.labels;
  idsf.feature_dim = 4;
  for (const int32_t label : workspace_.labels) {
    for (int k = 0; k < 4; ++k) {
      idsf.features.push_back(k == label + 1 ? 2.0f : 0.0f);
    }
  }
  ASSERT_TRUE(
      semantics::WriteIdsf(workspace_ / "bootstrap" / "idsf.bin", idsf).ok());
  const Status status =
      Render({workspace(), "--out", out(), "--what", "semantics"});
  ASSERT_TRUE(status.ok()) << status.message();
  const auto picture = ReadRgb(out() + "/photo1.png");
  ASSERT_TRUE(picture.ok());
  EXPECT_EQ(picture->width(), SyntheticWorkspace::kTrainingSide);
  EXPECT_GT(
      *std::max_element(picture->data(), picture->data() + picture->size()),
      128);
}

TEST_F(RenderCommandTest, FoldersOfStagesAreNoPlaceForPictures) {
  const std::string place =
      (workspace_.path() / "undistort" / "images").string();
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"--out", place},
        {"--path", "orbit", "--video", place + "/film.mp4"}}) {
    std::vector<std::string> arguments = {workspace()};
    arguments.insert(arguments.end(), words.begin(), words.end());
    const Status status = Render(arguments);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    EXPECT_THAT(status.message(), HasSubstr("the folder of stage undistort"));
  }
}

TEST_F(RenderCommandTest, OnlyShowsTheObjectAlone) {
  workspace_.AddInstances();
  ASSERT_TRUE(
      Render(
          {workspace(), "--out", out(), "--what", "instances", "--only", "2"})
          .ok());
  const auto ids = ReadLabels(out_.path() / "sub" / "photo1.png");
  ASSERT_TRUE(ids.ok());
  for (size_t k = 0; k < ids->size(); ++k) {
    EXPECT_TRUE(ids->data()[k] == 0 || ids->data()[k] == 2);
  }
  const Status status = Render({workspace(),
                                "--path",
                                "orbit",
                                "--only",
                                "2",
                                "--video",
                                (out_.path() / "2.mp4").string(),
                                "--seconds",
                                "0.2"});
  EXPECT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(Render({workspace(), "--out", out(), "--only", "9"}).code(),
            StatusCode::kInvalidArgument);
}

TEST_F(RenderCommandTest, WrongUsage) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{},
        {workspace()},
        {workspace(), workspace(), "--out", out()},
        {workspace(), "--out", out(), "--what", "normals"},
        {workspace(), "--out", out(), "--size", "-1"},
        {workspace(), "--out", out(), "--no-align"},
        {workspace(), "--out", out(), "--ids", "1"}}) {
    EXPECT_EQ(Render(arguments).code(), StatusCode::kInvalidArgument);
  }
}

TEST_F(RenderCommandTest, AWorkspaceWithoutAModelIsBadInput) {
  const Status none = Render({(out_ / "none").string(), "--out", out()});
  EXPECT_EQ(none.code(), StatusCode::kBadInput);
  EXPECT_THAT(none.message(), HasSubstr("no such workspace"));
  std::filesystem::remove_all(workspace_ / "reconstruct");
  const Status status = Render({workspace(), "--out", out()});
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("run stage reconstruct"));
}

TEST_F(RenderCommandTest, StopsWhenAsked) {
  cancellation_.Cancel();
  EXPECT_EQ(Render({workspace(), "--out", out()}).code(),
            StatusCode::kInterrupted);
}

TEST_F(RenderCommandTest, InstancesOfAnotherGranularity) {
  workspace_.AddInstances();
  EXPECT_EQ(Render({workspace(), "--out", out(), "--granularity", "1"}).code(),
            StatusCode::kInvalidArgument);
  const std::vector<std::string> ask = {
      workspace(), "--out", out(), "--what", "instances", "--granularity"};
  const auto largest_id = [&](const std::string& granularity) {
    std::vector<std::string> arguments = ask;
    arguments.push_back(granularity);
    const Status status = Render(arguments);
    EXPECT_TRUE(status.ok()) << status.message();
    int largest = 0;
    for (int k = 1; k < 6; ++k) {
      const auto ids = ReadLabels(std::filesystem::path(out()) /
                                  ("photo" + std::to_string(k) + ".png"));
      EXPECT_TRUE(ids.ok());
      for (size_t i = 0; ids.ok() && i < ids->size(); ++i) {
        largest = std::max(largest, static_cast<int>(ids->data()[i]));
      }
    }
    return largest;
  };
  std::vector<std::string> arguments = ask;
  arguments.push_back("0");
  EXPECT_THAT(Render(arguments).message(),
              HasSubstr("hierarchy.json: no such file"));
  workspace_.AddHierarchy();
  EXPECT_EQ(largest_id("0"), 3);
  EXPECT_EQ(largest_id("-23"), 2);
  EXPECT_EQ(largest_id("-47"), 1);
  EXPECT_EQ(largest_id("6"), 6);
}

TEST_F(RenderCommandTest, FolderThatCannotBeMade) {
  out_.Write("file", "");
  const Status status =
      Render({workspace(), "--out", (out_ / "file/below").string()});
  EXPECT_EQ(status.code(), StatusCode::kBadInput) << status.message();
}

}  // namespace
}  // namespace freegs::stages
