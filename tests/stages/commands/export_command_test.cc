// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/export_command.h"

#include <algorithm>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_text.h"
#include "pipeline/workspace.h"
#include "semantics/instances/palette.h"
#include "sfm/colmap/child_process.h"
#include "splat/scene/splat_format.h"
#include "splat/scene/spz_format.h"
#include "stages/scene/view_selection.h"
#include "tests/stages/synthetic_workspace.h"

namespace freegs::stages {
namespace {

using testing::HasSubstr;
using testing::Not;

class ExportCommandTest : public testing::Test {
 protected:
  Status Export(std::vector<std::string> arguments) {
    CommandContext context{output_, messages_, cancellation_, "freegs"};
    return RunExportCommand(arguments, context);
  }
  std::string File(const std::string& name) const {
    return (out_.path() / "new folder" / name).string();
  }
  std::string workspace() const { return workspace_.path().string(); }

  SyntheticWorkspace workspace_;
  TemporaryFolder out_;
  CancellationToken cancellation_;
  std::ostringstream output_;
  std::ostringstream messages_;
};

TEST_F(ExportCommandTest, PlyAndSplatAreTheModel) {
  ASSERT_TRUE(Export({workspace(), "--out", File("scene.ply")}).ok());
  EXPECT_EQ(ReadText(File("scene.ply")), splat::SerializePly(workspace_.model));
  ASSERT_TRUE(Export({workspace(), "--out", File("scene.SPLAT")}).ok());
  EXPECT_EQ(ReadText(File("scene.SPLAT")),
            splat::SerializeSplat(workspace_.model));
  EXPECT_THAT(output_.str(), HasSubstr("120 Gaussians"));
}

// As programs want it that read the files of 3DGS and nothing else.
TEST_F(ExportCommandTest, ADegreeAboveThatOfTheModelAddsZeros) {
  ASSERT_LT(workspace_.model.sh_degree, 3);
  ASSERT_TRUE(
      Export({workspace(), "--out", File("a.ply"), "--sh-degree", "3"}).ok());
  splat::GaussianModel model = splat::ReadPly(File("a.ply")).value().model;
  EXPECT_EQ(model.sh_degree, 3);
  EXPECT_THAT(ReadText(File("a.ply")), HasSubstr("f_rest_44\n"));
  model.SetShDegree(workspace_.model.sh_degree);
  EXPECT_EQ(splat::SerializePly(model), splat::SerializePly(workspace_.model));
}

TEST_F(ExportCommandTest, InstancesHaveFlatColoursAndTheSameShape) {
  workspace_.AddInstances();
  ASSERT_TRUE(
      Export({workspace(), "--out", File("i.ply"), "--what", "instances"})
          .ok());
  const auto file = splat::ReadPly(File("i.ply"));
  ASSERT_TRUE(file.ok()) << file.status().message();
  const splat::GaussianModel* const model = &file->model;
  EXPECT_EQ(model->sh_degree, 0);
  EXPECT_EQ(model->means, workspace_.model.means);
  EXPECT_EQ(model->log_scales, workspace_.model.log_scales);
  EXPECT_EQ(model->opacity_logits, workspace_.model.opacity_logits);
  for (size_t i = 0; i < model->size(); ++i) {
    const auto color = semantics::PaletteColor(workspace_.labels[i]);
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(255 * (splat::kShC0 * model->sh_dc[3 * i + c] + 0.5f),
                  color[c],
                  1e-3);
    }
  }
}

TEST_F(ExportCommandTest, OnlyAndWithoutPartTheScene) {
  workspace_.AddInstances();
  ASSERT_TRUE(
      Export({workspace(), "--out", File("only.ply"), "--only", "3,1"}).ok());
  ASSERT_TRUE(
      Export({workspace(), "--out", File("rest.ply"), "--without", "1,3"})
          .ok());
  const auto only = splat::ReadPly(File("only.ply"));
  const auto rest = splat::ReadPly(File("rest.ply"));
  ASSERT_TRUE(only.ok());
  ASSERT_TRUE(rest.ok());
  size_t num_only = 0;
  size_t num_rest = 0;
  for (size_t i = 0; i < workspace_.model.size(); ++i) {
    const int32_t label = workspace_.labels[i];
    const auto& model = label == 0 || label == 2 ? only->model : rest->model;
    size_t& k = label == 0 || label == 2 ? num_only : num_rest;
    ASSERT_LT(k, model.size());
    EXPECT_EQ(model.means[3 * k], workspace_.model.means[3 * i]);
    EXPECT_EQ(model.sh_dc[3 * k + 2], workspace_.model.sh_dc[3 * i + 2]);
    ++k;
  }
  EXPECT_EQ(num_only, only->model.size());
  EXPECT_EQ(num_rest, rest->model.size());
}

TEST_F(ExportCommandTest, InstancesThatAreNotThere) {
  EXPECT_EQ(Export({workspace(), "--out", File("a.ply"), "--only", "1"}).code(),
            StatusCode::kBadInput);
  workspace_.AddInstances();
  for (const char* ids : {"4", "0", "-1", "1,99"}) {
    const Status status =
        Export({workspace(), "--out", File("a.ply"), "--only", ids});
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << ids;
    EXPECT_THAT(status.message(), HasSubstr("there are 1, 2 and 3"));
  }
  for (const char* ids : {"x", "1,", ",1", "1 2", "1;2", "99999999999"}) {
    const Status status =
        Export({workspace(), "--out", File("a.ply"), "--without", ids});
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << ids;
    EXPECT_THAT(status.message(), HasSubstr("like 3,17")) << ids;
  }
  EXPECT_EQ(Export({workspace(),
                    "--out",
                    File("a.ply"),
                    "--only",
                    "1",
                    "--without",
                    "2"})
                .code(),
            StatusCode::kInvalidArgument);
  EXPECT_FALSE(std::filesystem::exists(File("a.ply")));
}

TEST_F(ExportCommandTest, UnknownSuffixNamesTheKnown) {
  const Status status = Export({workspace(), "--out", File("scene.obj")});
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr(".ply, .splat"));
  EXPECT_EQ(Export({workspace(), "--out", File("ply")}).code(),
            StatusCode::kInvalidArgument);
}

TEST_F(ExportCommandTest, SpzHoldsTheModel) {
  ASSERT_TRUE(Export({workspace(), "--out", File("scene.spz")}).ok());
  EXPECT_EQ(ReadText(File("scene.spz")),
            splat::SerializeSpz(workspace_.model).value());
  ASSERT_TRUE(
      Export({workspace(), "--out", File("flat.spz"), "--sh-degree", "0"})
          .ok());
  EXPECT_EQ(splat::ReadSpz(File("flat.spz")).value().sh_degree, 0);
}

TEST_F(ExportCommandTest, OneFileForEachObject) {
  workspace_.AddInstances();
  ASSERT_TRUE(Export({workspace(), "--objects", File("all")}).ok());
  for (const char* id : {"1", "2", "3"}) {
    ASSERT_TRUE(
        Export({workspace(), "--out", File("one.ply"), "--only", id}).ok());
    EXPECT_EQ(ReadText(File(std::string("all/") + id + ".ply")),
              ReadText(File("one.ply")));
  }
  EXPECT_THAT(output_.str(), HasSubstr("3 objects in"));
  ASSERT_TRUE(Export({workspace(),
                      "--objects",
                      File("some"),
                      "--format",
                      "spz",
                      "--without",
                      "2",
                      "--what",
                      "instances"})
                  .ok());
  EXPECT_TRUE(splat::ReadSpz(File("some/1.spz")).ok());
  EXPECT_FALSE(std::filesystem::exists(File("some/2.spz")));
  EXPECT_TRUE(splat::ReadSpz(File("some/3.spz")).ok());
}

TEST_F(ExportCommandTest, OneGaussianDoesNotKeepAnObjectFromSpz) {
  workspace_.AddInstances();
  // Gaussian 4 of instance 1 is larger than the format can say.
  workspace_.model.opacity_logits[4] = 2;
  workspace_.model.log_scales[12] = 8;
  ASSERT_TRUE(splat::WritePly(workspace_ / "reconstruct" / "point_cloud.ply",
                              workspace_.model)
                  .ok());
  const Status status =
      Export({workspace(), "--objects", File("all"), "--format", "spz"});
  ASSERT_TRUE(status.ok()) << status.message();
  const auto object = splat::ReadSpz(File("all/1.spz"));
  ASSERT_TRUE(object.ok()) << object.status().message();
  EXPECT_EQ(object->size(), 30u);
}

TEST_F(ExportCommandTest, AnObjectDoesNotReplaceWhatIsImported) {
  workspace_.AddInstances();
  WriteText(workspace_ / "config.ini",
            "[reconstruct]\nimport = " + File("objects/1.ply") + "\n");
  WriteText(File("objects/1.ply"), "mine");
  const Status status =
      Export({workspace(), "--objects", File("objects"), "--only", "1"});
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(ReadText(File("objects/1.ply")), "mine");
  EXPECT_TRUE(
      Export({workspace(), "--objects", File("objects"), "--only", "2"}).ok());
}

TEST_F(ExportCommandTest, ObjectsOfAnEarlierExportAreCounted) {
  workspace_.AddInstances();
  const std::string all = File("all");
  ASSERT_TRUE(Export({workspace(), "--objects", all}).ok());
  EXPECT_THAT(output_.str(), Not(HasSubstr("also holds")));
  for (const char* name : {"17.ply", "17.spz", "seventeen.ply", "17b.ply"}) {
    WriteText(std::filesystem::path(all) / name, "");
  }
  ASSERT_TRUE(Export({workspace(), "--objects", all, "--only", "2"}).ok());
  EXPECT_THAT(output_.str(), HasSubstr("also holds 3 .ply files"));
  EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(all) / "3.ply"));
}

TEST_F(ExportCommandTest, FilesOfStagesAreNotOverwritten) {
  workspace_.AddInstances();
  const std::string model =
      (workspace_ / "reconstruct" / "point_cloud.ply").string();
  const std::string before = ReadText(model);
  const std::filesystem::path link = out_ / "link";
  std::filesystem::create_directory_symlink(workspace_ / "reconstruct", link);
  const std::vector<std::vector<std::string>> wrong = {
      {"--out", model, "--only", "3"},
      {"--out", (link / "point_cloud.ply").string()},
      {"--out", (workspace_ / "bootstrap/../export/new/a.ply").string()},
      {"--objects", (workspace_ / "reconstruct").string()},
      {"--out", (workspace_ / "undistort/sparse").string(), "--what", "colmap"},
      {"--out",
       (workspace_ / "bootstrap" / "boxes.json").string(),
       "--what",
       "boxes"}};
  for (std::vector<std::string> words : wrong) {
    words.insert(words.begin(), workspace());
    const Status status = Export(words);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << words[2];
    EXPECT_THAT(status.message(), HasSubstr("the folder of stage")) << words[2];
  }
  EXPECT_EQ(ReadText(model), before);
  EXPECT_FALSE(std::filesystem::exists(workspace_ / "export"));
  // Beside the stages there is room.
  const std::string beside = (workspace_ / "reconstruct.ply").string();
  EXPECT_TRUE(Export({workspace(), "--out", beside}).ok());
}

TEST_F(ExportCommandTest, AWorkspaceThatIsNotThere) {
  const Status status =
      Export({File("none"), "--out", (out_ / "scene.ply").string()});
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("no such workspace"));
}

TEST_F(ExportCommandTest, MasksOfAllPhotosAsCoco) {
  workspace_.AddInstances();
  workspace_.instances[1].words = {"red apple"};
  ASSERT_TRUE(
      semantics::WriteInstances(workspace_ / "bootstrap" / "instances.json",
                                workspace_.instances)
          .ok());
  ASSERT_TRUE(
      Export({workspace(), "--what", "masks", "--out", File("coco.json")})
          .ok());
  const nlohmann::json file = ReadJson(File("coco.json")).value();
  ASSERT_EQ(file["images"].size(), workspace_.views.size());
  EXPECT_EQ(file["categories"],
            nlohmann::json::parse(R"([{"id": 1, "name": "object"},
                                      {"id": 2, "name": "red apple"}])"));
  ThreadPool pool(1);
  splat::RenderOptions render;
  render.background = {1, 1, 1};
  int64_t seen = 0;
  for (const nlohmann::json& image : file["images"]) {
    EXPECT_EQ(image["width"], SyntheticWorkspace::kWidth);
    EXPECT_EQ(image["height"], SyntheticWorkspace::kHeight);
    const View view =
        FindView(workspace_.views, image["file_name"].get<std::string>())
            .value();
    const Image<int32_t> labels = splat::RenderLabels(workspace_.model,
                                                      view.camera,
                                                      view.cam_from_world,
                                                      render,
                                                      pool,
                                                      workspace_.labels);
    for (const nlohmann::json& annotation : file["annotations"]) {
      if (annotation["image_id"] != image["id"]) continue;
      const int id = annotation["instance_id"];
      EXPECT_EQ(annotation["category_id"], id == 2 ? 2 : 1);
      EXPECT_NEAR(
          annotation["area"].get<double>(),
          std::count(labels.data(), labels.data() + labels.size(), id - 1),
          3);
      EXPECT_EQ(annotation["segmentation"]["size"],
                nlohmann::json({image["height"], image["width"]}));
      EXPECT_EQ(annotation["iscrowd"], 0);
      seen += annotation["area"].get<int64_t>();
    }
  }
  EXPECT_GT(seen, 0);
  ASSERT_TRUE(Export({workspace(),
                      "--what",
                      "masks",
                      "--out",
                      File("one.json"),
                      "--only",
                      "2"})
                  .ok());
  const nlohmann::json one = ReadJson(File("one.json")).value();
  EXPECT_FALSE(one["annotations"].empty());
  for (const nlohmann::json& annotation : one["annotations"]) {
    EXPECT_EQ(annotation["instance_id"], 2);
  }
}

TEST_F(ExportCommandTest, BoxesOfSomeInstances) {
  workspace_.AddInstances();
  ASSERT_TRUE(Export({workspace(),
                      "--what",
                      "boxes",
                      "--out",
                      File("boxes.json"),
                      "--without",
                      "2"})
                  .ok());
  const nlohmann::json file = ReadJson(File("boxes.json")).value();
  ASSERT_EQ(file["objects"].size(), 2u);
  EXPECT_EQ(file["objects"][0]["id"], 1);
  EXPECT_EQ(file["objects"][1]["id"], 3);
}

TEST_F(ExportCommandTest, ColmapText) {
  ASSERT_TRUE(
      Export({workspace(), "--what", "colmap", "--out", File("model")}).ok());
  EXPECT_EQ(sfm::DetectModelFormat(File("model")), sfm::ModelFormat::kText);
  EXPECT_EQ(sfm::ReadModel(File("model")).value().images.size(),
            workspace_.views.size());
  std::string said;
  sfm::ChildCommand analyzer;
  analyzer.argv = {"colmap", "model_analyzer", "--path", File("model")};
  analyzer.environment = {{"QT_QPA_PLATFORM", "offscreen"}};
  const auto result = sfm::RunChild(
      analyzer,
      [&said](std::string_view line) { said += std::string(line) + "\n"; },
      nullptr);
  if (result.status().code() == StatusCode::kMissingDependency) {
    GTEST_SKIP() << "colmap is not installed";
  }
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_TRUE(result->ok()) << result->tail;
  EXPECT_THAT(said, HasSubstr("mages: 6"));
}

// Other programs read these first, or with the text files.
TEST_F(ExportCommandTest, FilesThatHideTheText) {
  for (const char* const name : {"cameras.bin",
                                 "images.bin",
                                 "points3D.bin",
                                 "rigs.bin",
                                 "frames.bin",
                                 "rigs.txt",
                                 "frames.txt"}) {
    const std::filesystem::path folder = File("model_" + std::string(name));
    std::filesystem::create_directories(folder);
    ASSERT_TRUE(WriteFileAtomic(folder / name, "").ok());
    const Status status =
        Export({workspace(), "--what", "colmap", "--out", folder.string()});
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << name;
    EXPECT_THAT(status.message(), HasSubstr(name));
    EXPECT_FALSE(std::filesystem::exists(folder / "cameras.txt"));
  }
  // Its own files are replaced.
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(
        Export({workspace(), "--what", "colmap", "--out", File("again")}).ok());
  }
}

TEST_F(ExportCommandTest, WordsThatDoNotFit) {
  const std::vector<std::vector<std::string>> wrong = {
      {"--out", "a.json"},
      {"--out", "a.ply", "--what", "masks"},
      {"--out", "a.ply", "--what", "boxes"},
      {"--out", "a.ply", "--objects", "b"},
      {"--out", "a.ply", "--format", "spz"},
      {"--objects", "b", "--what", "boxes"},
      {"--objects", "b", "--format", "obj"},
      {"--out", "b", "--what", "colmap", "--only", "1"},
      {"--out", "b.ply", "--what", "colmap"},
      {"--objects", "b.PLY"},
      {"--out", "a.ply", "--only", "1", "--without", "2"},
      {"--out", "a.ply", "--sh-degree", "4"}};
  for (std::vector<std::string> words : wrong) {
    words.insert(words.begin(), workspace());
    EXPECT_EQ(Export(words).code(), StatusCode::kInvalidArgument) << words[2];
  }
}

TEST_F(ExportCommandTest, WrongUsage) {
  EXPECT_EQ(Export({}).code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(Export({workspace()}).code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(Export({workspace(), "--out", "a.ply", "--unknown", "3"}).code(),
            StatusCode::kInvalidArgument);
  EXPECT_EQ(Export({"a", "b", "--out", "a.ply"}).code(),
            StatusCode::kInvalidArgument);
}

TEST_F(ExportCommandTest, AFolderThatIsNoWorkspaceIsBadInput) {
  const Status status =
      Export({out_.path().string(), "--out", File("scene.ply")});
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("run stage reconstruct"));
}

TEST_F(ExportCommandTest, ADamagedModelIsBadInput) {
  WriteText(workspace_ / "reconstruct" / "point_cloud.ply", "ply\nformat");
  EXPECT_EQ(Export({workspace(), "--out", File("scene.ply")}).code(),
            StatusCode::kBadInput);
}

TEST_F(ExportCommandTest, WarnsWhileARunIsWorking) {
  EXPECT_TRUE(Export({workspace(), "--out", File("scene.ply")}).ok());
  EXPECT_EQ(messages_.str(), "");
  const auto lock = pipeline::WorkspaceLock::Acquire(workspace_.path());
  ASSERT_TRUE(lock.ok());
  EXPECT_TRUE(Export({workspace(), "--out", File("scene.ply")}).ok());
  EXPECT_THAT(messages_.str(), HasSubstr("a run is working in"));
}

}  // namespace
}  // namespace freegs::stages
