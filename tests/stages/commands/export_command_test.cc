// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/export_command.h"

#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/workspace.h"
#include "semantics/instances/palette.h"
#include "splat/scene/splat_format.h"
#include "tests/stages/synthetic_workspace.h"

namespace freegs::stages {
namespace {

using testing::HasSubstr;

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
    EXPECT_THAT(status.message(), HasSubstr("there are 1, 2, 3"));
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
