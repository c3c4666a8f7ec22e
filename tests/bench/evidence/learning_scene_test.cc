// SPDX-License-Identifier: BSD-3-Clause

#include "bench/evidence/learning_scene.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "tests/stages/synthetic_workspace.h"
#include "tests/temporary_folder.h"

namespace freegs::evidence {
namespace {

TEST(LearningSceneTest, ATruthWithoutMasksIsRefused) {
  const stages::SyntheticWorkspace workspace;
  const TemporaryFolder truth;
  ThreadPool pool(1);
  const auto load = [&](const std::string& ending) {
    return LoadLearningScene(workspace.path().string() + ending,
                             truth.path(),
                             /*with_semantics=*/false,
                             pool);
  };
  const Status status = load("").status();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), testing::HasSubstr(truth.path().string()));

  const std::filesystem::path folder = truth / "gt/instance";
  std::filesystem::create_directories(folder);
  const ImageU16 mask(workspace.kWidth, workspace.kHeight, 1, 7);
  ASSERT_TRUE(WriteLabels(folder / "photo1.png", mask).ok());
  // A slash at the end of the workspace does not take its name away.
  for (const std::string ending : {"", "/", "/./"}) {
    const auto divisions = load(ending);
    ASSERT_TRUE(divisions.ok()) << divisions.status().message();
    EXPECT_EQ(divisions->size(), static_cast<size_t>(semantics::kNumDivisions));
    for (const LearningScene& scene : *divisions) {
      EXPECT_EQ(scene.name, workspace.path().filename());
      EXPECT_GT(scene.segment_pixels.at(7), 0);
    }
  }
}

}  // namespace
}  // namespace freegs::evidence
