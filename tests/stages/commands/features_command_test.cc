// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/features_command.h"

#include <algorithm>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "pipeline/exit_code.h"
#include "stages/scene/heat_map.h"
#include "tests/semantics/clip/model_files.h"

namespace freegs::stages {
namespace {

using semantics::ModelCopy;
using semantics::TinyClip;
using testing::HasSubstr;

class FeaturesCommandTest : public testing::Test {
 protected:
  int Features(std::vector<std::string> arguments) {
    output_.str("");
    CommandContext context{output_, messages_, cancellation_, "freegs"};
    const Status status = RunFeaturesCommand(arguments, context);
    message_ = status.message();
    return pipeline::ExitCode(status.code());
  }

  // The arguments of a good call.
  std::vector<std::string> Good() const {
    return {(TinyClip() / "reference.png").string(),
            "--text",
            "red apple",
            "--model",
            TinyClip().string(),
            "--out",
            out()};
  }
  std::string out() const { return (folder_ / "sub/heat.png").string(); }

  TemporaryFolder folder_;
  CancellationToken cancellation_;
  std::ostringstream output_;
  std::ostringstream messages_;
  std::string message_;
};

TEST_F(FeaturesCommandTest, WritesAPicture) {
  ASSERT_EQ(Features(Good()), 0) << message_;
  EXPECT_THAT(output_.str(), HasSubstr("of 331 x 217"));
  const auto picture = ReadRgb(out());
  ASSERT_TRUE(picture.ok());
  EXPECT_EQ(picture->width(), 331);
  auto arguments = Good();
  arguments[5] = "-o";
  arguments.insert(arguments.end(), {"--size", "64", "--dense-size", "32"});
  ASSERT_EQ(Features(arguments), 0) << message_;
  EXPECT_EQ(ReadRgb(out())->width(), 64);
}

TEST_F(FeaturesCommandTest, AModelComesWithTheProgram) {
  auto arguments = Good();
  arguments.erase(arguments.begin() + 3, arguments.begin() + 5);
  EXPECT_EQ(Features(arguments), 0) << message_;
  EXPECT_TRUE(ReadRgb(out()).ok());
}

TEST_F(FeaturesCommandTest, TheModelMayBringItsUpsampler) {
  ASSERT_EQ(Features(Good()), 0) << message_;
  const std::string without = output_.str();
  const ModelCopy model;
  model.AddUpsampler();
  auto arguments = Good();
  arguments[4] = model.path().string();
  ASSERT_EQ(Features(arguments), 0) << message_;
  EXPECT_NE(output_.str(), without);
}

TEST_F(FeaturesCommandTest, TheCacheDoesNotMatter) {
  auto arguments = Good();
  arguments.insert(arguments.end(), {"--cache", (folder_ / "cache").string()});
  ASSERT_EQ(Features(arguments), 0) << message_;
  const std::string first = ReadText(out());
  const std::string text = output_.str();
  EXPECT_FALSE(std::filesystem::is_empty(folder_ / "cache"));
  arguments.insert(arguments.end(), {"--threads", "3"});
  ASSERT_EQ(Features(arguments), 0) << message_;
  EXPECT_EQ(ReadText(out()), first);
  EXPECT_EQ(output_.str(), text);
}

TEST_F(FeaturesCommandTest, LongWordsAreCutWithAWord) {
  auto arguments = Good();
  arguments[2] = std::string(500, '.') + " red";
  for (int i = 0; i < 100; ++i) arguments[2] += " red";
  ASSERT_EQ(Features(arguments), 0) << message_;
  EXPECT_THAT(messages_.str(), HasSubstr("only their beginning"));
}

TEST_F(FeaturesCommandTest, WrongUsageIs2) {
  EXPECT_EQ(Features({}), 2);
  EXPECT_EQ(Features({Good()[0]}), 2);
  EXPECT_THAT(message_, HasSubstr("needs --text"));
  for (const auto& more :
       std::vector<std::vector<std::string>>{{"second.png"},
                                             {"--size", "1"},
                                             {"--range-sigma", "0"},
                                             {"--dense-size", "100"},
                                             {"--unknown", "1"}}) {
    auto arguments = Good();
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(Features(arguments), 2) << more[0];
  }
  auto arguments = Good();
  arguments[2] = std::string(20000, 'x');
  EXPECT_EQ(Features(arguments), 2);
  arguments = Good();
  *(std::ranges::find(arguments, "--out") + 1) = arguments[0];
  EXPECT_EQ(Features(arguments), 2);
  EXPECT_THAT(message_, HasSubstr("would replace the photo"));
  WriteText(folder_ / "stage/stage.json", "{}");
  arguments = Good();
  arguments.insert(arguments.end(),
                   {"--cache", (folder_ / "stage/cache").string()});
  EXPECT_EQ(Features(arguments), 2);
  EXPECT_THAT(message_, HasSubstr("which a stage made"));
}

TEST_F(FeaturesCommandTest, BadImagesAre3) {
  WriteText(folder_ / "text.png", "not an image");
  for (const std::string& image : {(folder_ / "missing.png").string(),
                                   (folder_ / "text.png").string(),
                                   folder_.path().string()}) {
    auto arguments = Good();
    arguments[0] = image;
    EXPECT_EQ(Features(arguments), 3) << image;
    EXPECT_THAT(message_, HasSubstr(image));
  }
}

TEST_F(FeaturesCommandTest, MissingAndWrongModelsAre5) {
  auto arguments = Good();
  arguments[4] = (folder_ / "none").string();
  EXPECT_EQ(Features(arguments), 5);
  EXPECT_THAT(message_, HasSubstr("none"));
  for (const char* name : {"dense.onnx", "text.onnx", "vocab"}) {
    const ModelCopy model;
    arguments[4] = model.path().string();
    model.Replace(name, "damaged");
    EXPECT_EQ(Features(arguments), 5);
    EXPECT_THAT(message_, HasSubstr(name));
    WriteText(model.path() / name, "other content");
    EXPECT_EQ(Features(arguments), 5);
    EXPECT_THAT(message_, HasSubstr(name));
    EXPECT_THAT(message_, HasSubstr("freegs_pipeline model"));
  }
  EXPECT_FALSE(std::filesystem::exists(out()));
}

TEST_F(FeaturesCommandTest, StopsWhenAsked) {
  cancellation_.Cancel();
  EXPECT_EQ(Features(Good()), 130);
}

TEST(HeatMapTest, IsGreyWhereThereIsNothing) {
  ImageU8 picture(2, 1, 3, 100);
  ImageF values(2, 1, 1);
  values(0, 0) = 0.4f;
  values(1, 0) = 0.9f;
  const ImageU8 heat = HeatMap(picture, values, 0.5, 0.8);
  EXPECT_EQ(heat(0, 0, 0), 60);
  EXPECT_EQ(heat(0, 0, 2), 60);
  EXPECT_GT(heat(1, 0, 0), 150);
}

TEST_F(FeaturesCommandTest, PictureThatCannotBeWritten) {
  std::vector<std::string> arguments = Good();
  arguments.back() = (TinyClip() / "heat").string();
  EXPECT_EQ(Features(arguments), 2);
  EXPECT_THAT(message_, HasSubstr(".png"));
  arguments.back() = (TinyClip() / "reference.png/heat.png").string();
  EXPECT_EQ(Features(arguments), 3);
}

}  // namespace
}  // namespace freegs::stages
