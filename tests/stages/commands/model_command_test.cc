// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/model_command.h"

#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/exit_code.h"
#include "semantics/clip/model_folder.h"
#include "tests/semantics/clip_export/random_clip.h"

namespace freegs::stages {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class ModelCommandTest : public testing::Test {
 protected:
  int Model(const std::vector<std::string>& arguments) {
    CommandContext context{output_, messages_, cancellation_, "freegs"};
    const Status status = RunModelCommand(arguments, context);
    message_ = status.message();
    return pipeline::ExitCode(status.code());
  }

  const TemporaryFolder folder_;
  const std::string source_ = (folder_ / "source").string();
  const std::string out_ = (folder_ / "a/out").string() + "/";
  CancellationToken cancellation_;
  std::ostringstream output_;
  std::ostringstream messages_;
  std::string message_;
};

TEST_F(ModelCommandTest, WritesAModelFolder) {
  const semantics::RandomClip clip;
  clip.WriteHuggingFace(source_, "quick_gelu");
  ASSERT_EQ(Model({source_, "--out", out_}), 0) << message_;
  EXPECT_THAT(output_.str(),
              AllOf(HasSubstr("8 dimensions"), HasSubstr("--bootstrap.model")));
  EXPECT_TRUE(semantics::ModelFolder::Open(out_).ok());
  WriteText(folder_ / "merges", semantics::RandomClip::kMerges);
  std::filesystem::remove(folder_ / "source/merges.txt");
  EXPECT_EQ(Model({source_, "--out", out_}), 5);
  ASSERT_EQ(Model({source_ + "/model.safetensors",
                   "--out",
                   out_,
                   "--merges",
                   (folder_ / "merges").string(),
                   "--dense-size",
                   "32"}),
            0)
      << message_;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "a/out/dense32.onnx"));
}

TEST_F(ModelCommandTest, FoldersOfStagesAreRefused) {
  const semantics::RandomClip clip;
  clip.WriteHuggingFace(source_, "quick_gelu");
  WriteText(folder_ / "a/stage.json", "{}");
  EXPECT_EQ(Model({source_, "--out", out_}), 2);
  EXPECT_THAT(message_, HasSubstr("which a stage made"));
  EXPECT_FALSE(std::filesystem::exists(out_));
}

TEST_F(ModelCommandTest, ExitCodes) {
  EXPECT_EQ(Model({}), 2);
  EXPECT_EQ(Model({source_}), 2);
  EXPECT_EQ(Model({source_, "--out", out_, "--dense-size", "-1"}), 2);
  for (const char* suffix : {"", ".safetensors"}) {
    EXPECT_EQ(Model({source_ + suffix, "--out", out_}), 3);
    EXPECT_THAT(message_, HasSubstr("no such file"));
  }
  EXPECT_EQ(Model({source_ + ".pt", "--out", out_}), 5);
  EXPECT_THAT(message_, HasSubstr("export_clip.py"));
  WriteText(source_ + ".safetensors", "nothing");
  EXPECT_EQ(Model({source_ + ".safetensors", "--out", out_}), 5);
  EXPECT_THAT(message_, HasSubstr("source.safetensors"));
  EXPECT_EQ(Model({source_, "--out", folder_.path().string()}), 3);
}

}  // namespace
}  // namespace freegs::stages
