// SPDX-License-Identifier: BSD-3-Clause

#include "stages/query/query_session.h"

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "stages/query/file_stamp.h"
#include "tests/stages/synthetic_workspace.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

class QuerySessionTest : public testing::Test {
 protected:
  QuerySessionTest() {
    workspace_.AddInstances();
    workspace_.AddHierarchy();
    click_.click = ViewPlace{"photo1", {24, 18}};
  }

  // Without the times, which differ.
  nlohmann::json Ask(const QueryRequest& request) {
    const auto answer = session_.Ask(request, pool_);
    EXPECT_TRUE(answer.ok()) << answer.status().message();
    if (!answer.ok()) return {};
    nlohmann::json json = *answer;
    json.erase("timings");
    return json;
  }

  SyntheticWorkspace workspace_;
  ThreadPool pool_{2};
  QuerySession session_{workspace_.path()};
  QueryRequest click_;
};

TEST_F(QuerySessionTest, OneAnswerDoesNotChangeTheNext) {
  const nlohmann::json before = Ask(click_);
  EXPECT_EQ(before["note"], "");
  QueryRequest wider = click_;
  wider.level = 1;
  const nlohmann::json first = Ask(wider);
  EXPECT_EQ(first["query"]["level"], 1);
  EXPECT_EQ(Ask(wider), first);
  EXPECT_EQ(Ask(click_), before);
}

TEST_F(QuerySessionTest, AFaultIsForgottenWhenItsCauseIs) {
  const fs::path file = workspace_ / "bootstrap/instances.json";
  const std::string good = ReadText(file);
  WriteText(file, "[]x");
  EXPECT_EQ(session_.Ask(click_, pool_).status().code(), StatusCode::kBadInput);
  fs::remove(file);
  EXPECT_EQ(session_.Ask(click_, pool_).status().code(), StatusCode::kBadInput);
  WriteText(file, good);
  EXPECT_FALSE(Ask(click_)["hits"].empty());
  QueryRequest nowhere;
  nowhere.click = ViewPlace{"nowhere", {1, 1}};
  EXPECT_EQ(session_.Ask(nowhere, pool_).status().code(),
            StatusCode::kInvalidArgument);
  EXPECT_FALSE(Ask(click_)["hits"].empty());
}

TEST(FileStamp, TellsThatAFileChanged) {
  const TemporaryFolder folder;
  const auto stamp = [&folder] { return FileStamp({folder / "a"}); };
  const std::string missing = stamp();
  folder.Write("a", "1");
  const std::string first = stamp();
  EXPECT_NE(first, missing);
  EXPECT_EQ(stamp(), first);
  folder.Write("b", "1");
  fs::rename(folder / "b", folder / "a");
  EXPECT_NE(stamp(), first);
}

TEST(FileStamp, TellsOfAllThatAnAnswerDependsOn) {
  const TemporaryFolder workspace;
  const auto photos = [&] { return PhotosStamp(workspace.path()); };
  const auto query = [&] { return QueryStamp(workspace.path()); };
  for (const char* name : {"ingest/images.json",
                           "undistort/sparse/cameras.bin",
                           "undistort/sparse/images.txt",
                           "undistort/sparse/points3D.bin"}) {
    const std::string before = photos() + query();
    workspace.Write(name, "1");
    EXPECT_NE(photos(), before.substr(0, 16)) << name;
    EXPECT_NE(query(), before.substr(16)) << name;
  }
  const std::string same = photos();
  for (const char* name : {"reconstruct/point_cloud.ply",
                           "reconstruct/stage.json",
                           "bootstrap/idsf.bin",
                           "bootstrap/stage.json"}) {
    const std::string before = query();
    workspace.Write(name, "1");
    EXPECT_NE(query(), before) << name;
  }
  EXPECT_EQ(photos(), same);
}

}  // namespace
}  // namespace freegs::stages
