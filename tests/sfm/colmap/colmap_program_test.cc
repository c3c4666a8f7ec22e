// SPDX-License-Identifier: BSD-3-Clause
// Finding COLMAP and asking what it knows.

#include "sfm/colmap/colmap_program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sfm/fake_colmap.h"

namespace freegs::sfm {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

TEST(ColmapProgram, MissingProgramComesWithAdvice) {
  const auto colmap = ColmapProgram::Find("/nonexistent/colmap", nullptr);
  ASSERT_FALSE(colmap.ok());
  EXPECT_EQ(colmap.status().code(), StatusCode::kMissingDependency);
  EXPECT_THAT(colmap.status().message(), HasSubstr("apt install colmap"));
}

TEST(ColmapProgram, OtherProgramsAreRefused) {
  const auto colmap = ColmapProgram::Find("/bin/true", nullptr);
  ASSERT_FALSE(colmap.ok());
  EXPECT_EQ(colmap.status().code(), StatusCode::kMissingDependency);
}

TEST(ColmapProgram, VersionAndOptions) {
  for (const auto& [dialect, version] :
       {std::pair("3", "3.8"), std::pair("4", "4.1.1")}) {
    const TemporaryFolder folder;
    auto colmap = ColmapProgram::Find(
        MakeFakeColmap(folder.path(), {{"FAKE_COLMAP_DIALECT", dialect}}),
        nullptr);
    ASSERT_TRUE(colmap.ok()) << colmap.status().message();
    EXPECT_EQ(colmap->version(), version);
    const auto options = colmap->Options("feature_extractor", nullptr);
    ASSERT_TRUE(options.ok());
    EXPECT_THAT(*options, Contains("help"));
    EXPECT_THAT(*options, Contains("ImageReader.single_camera"));
    const bool is_new = std::string(dialect) == "4";
    EXPECT_EQ(options->contains("FeatureExtraction.use_gpu"), is_new);
    EXPECT_EQ(options->contains("SiftExtraction.use_gpu"), !is_new);
    const auto unknown = colmap->Options("global_mapper", nullptr);
    EXPECT_EQ(unknown.status().code(), StatusCode::kMissingDependency);
  }
}

TEST(ColmapArguments, TakesWhatTheProgramHas) {
  ColmapArguments arguments({{"colmap", "x"}, {}, {}}, {"a", "c", "d"});
  arguments.Require("a", "1");
  EXPECT_TRUE(arguments.Prefer({"b", "c"}, "2"));
  EXPECT_FALSE(arguments.Prefer({"e"}, "3"));
  arguments.AddAll({"d", "e", "a"}, "4");
  const auto command = arguments.Finish();
  ASSERT_TRUE(command.ok());
  EXPECT_THAT(
      command->argv,
      ElementsAre(
          "colmap", "x", "--a", "1", "--c", "2", "--d", "4", "--a", "4"));
  arguments.Require("missing", "5");
  const auto failed = arguments.Finish();
  EXPECT_EQ(failed.status().code(), StatusCode::kMissingDependency);
  EXPECT_THAT(failed.status().message(), HasSubstr("--missing"));
}

}  // namespace
}  // namespace freegs::sfm
