// SPDX-License-Identifier: BSD-3-Clause
// stage.json: round trip, differences in words, hostile content.

#include "pipeline/stage_record.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace freegs::pipeline {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

StageRecord Example() {
  StageRecord record;
  record.fingerprint.stage = "sfm";
  record.fingerprint.version = 3;
  record.fingerprint.options = {{"sfm.a", "1"}, {"sfm.b", "x y"}};
  record.fingerprint.inputs = {
      {"ingest/images.json", {"abc", 1}},
      {"photos", {"def", 20, "/home/me/photos", "../photos"}}};
  record.outcome = StageOutcome::kFailed;
  record.program_version = "1.2.3";
  record.other_options = {{"sfm.c", "2"}};
  record.wall_seconds = 1.5;
  record.cpu_seconds = 2.5;
  record.peak_memory_bytes = int64_t{5} << 32;
  record.expected_memory_bytes = int64_t{6} << 32;
  record.expected_seconds = 90.5;
  record.resumed = true;
  record.summary = {{"registered", 50}};
  record.outputs = {{"sparse/0/cameras.bin", 72}};
  record.contents = {"database.db", "sparse"};
  record.error_code = StatusCode::kUnusableResult;
  record.error = "too few photos";
  return record;
}

TEST(StageRecordTest, RoundTrip) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteStageRecord(folder.path(), Example()).ok());
  const StatusOr<StageRecord> read = ReadStageRecord(folder.path());
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(ToJson(*read), ToJson(Example()));
  EXPECT_EQ(read->fingerprint, Example().fingerprint);
  EXPECT_EQ(read->fingerprint.inputs.at("photos").path, "/home/me/photos");
  EXPECT_EQ(read->fingerprint.inputs.at("photos").from_workspace, "../photos");
  EXPECT_EQ(read->fingerprint.inputs.at("ingest/images.json").path, "");
  EXPECT_EQ(read->expected_memory_bytes, int64_t{6} << 32);
  EXPECT_EQ(read->expected_seconds, 90.5);
  EXPECT_EQ(read->error_code, StatusCode::kUnusableResult);
}

TEST(StageRecordTest, MissingFileIsBadInput) {
  EXPECT_EQ(ReadStageRecord("/no/such/folder").status().code(),
            StatusCode::kBadInput);
}

TEST(StageRecordTest, EveryTruncationIsRefused) {
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteStageRecord(folder.path(), Example()).ok());
  const std::string text = ReadText(RecordPath(folder.path()));
  for (size_t n = 0; n + 2 < text.size(); n += 7) {
    WriteText(RecordPath(folder.path()), text.substr(0, n));
    EXPECT_EQ(ReadStageRecord(folder.path()).status().code(),
              StatusCode::kBadInput);
  }
}

TEST(StageRecordTest, EveryWrongOrMissingFieldIsRefused) {
  const json good = ToJson(Example());
  for (const auto& [key, value] : good.items()) {
    if (key == "error") continue;
    json missing = good;
    missing.erase(key);
    // Records of older programs lack these.
    EXPECT_EQ(
        RecordFromJson(missing).ok(),
        key == "outputs" || key == "contents" || key.starts_with("expected_"))
        << key;
    json wrong = good;
    wrong[key] = json::array({1});
    EXPECT_THAT(RecordFromJson(wrong).status().message(), HasSubstr(key));
  }
  json odd = good;
  odd["status"] = "finished";
  EXPECT_FALSE(RecordFromJson(odd).ok());
  odd = good;
  odd["options"]["sfm.a"] = 1;
  EXPECT_FALSE(RecordFromJson(odd).ok());
  odd = good;
  odd["inputs"]["photos"] = "def";
  EXPECT_FALSE(RecordFromJson(odd).ok());
  odd = good;
  odd["inputs"]["photos"]["path"] = 1;
  EXPECT_FALSE(RecordFromJson(odd).ok());
  odd = good;
  odd["inputs"]["photos"]["from_workspace"] = 1;
  EXPECT_FALSE(RecordFromJson(odd).ok());
  odd = good;
  odd["outputs"]["sparse/0/cameras.bin"] = -1;
  EXPECT_FALSE(RecordFromJson(odd).ok());
  odd = good;
  odd["error"]["code"] = "bad luck";
  EXPECT_FALSE(RecordFromJson(odd).ok());
}

TEST(StageRecordTest, DeeplyNestedJsonIsRefused) {
  const TemporaryFolder folder;
  const std::string lists(1'000'000, '[');
  for (const std::string& text :
       {lists, "{\"stage\": " + lists, lists + std::string(1'000'000, ']')}) {
    WriteText(RecordPath(folder.path()), text);
    const auto record = ReadStageRecord(folder.path());
    EXPECT_EQ(record.status().code(), StatusCode::kBadInput);
    EXPECT_THAT(record.status().message(), HasSubstr("stage.json: nested"));
  }
}

TEST(StageRecordTest, TextThatIsNotUtf8CanBeWritten) {
  const TemporaryFolder folder;
  StageRecord record = Example();
  record.error = "photo \xff.jpg";
  ASSERT_TRUE(WriteStageRecord(folder.path(), record).ok());
  EXPECT_EQ(ReadStageRecord(folder.path())->error, "photo \xef\xbf\xbd.jpg");
}

TEST(StageRecordTest, DifferencesInWords) {
  const StageFingerprint then = Example().fingerprint;
  StageFingerprint now = then;
  EXPECT_EQ(Difference(then, now), "");
  now.options["sfm.a"] = "2";
  EXPECT_EQ(Difference(then, now), "option sfm.a changed 1 -> 2");
  now.options["sfm.a"] = "";
  EXPECT_EQ(Difference(then, now), "option sfm.a changed 1 -> ''");
  now.options.erase("sfm.a");
  EXPECT_EQ(Difference(then, now), "option sfm.a is gone");
  EXPECT_EQ(Difference(now, then), "option sfm.a is new");
  now = then;
  now.version = 4;
  EXPECT_THAT(Difference(then, now), HasSubstr("version"));
  now = then;
  now.inputs["photos"].path = "/elsewhere/photos";
  EXPECT_EQ(Difference(then, now), "");
  now.inputs["list.txt"] = {"missing", 0};
  EXPECT_EQ(Difference(then, now), "input list.txt is missing");
  now = then;
  now.inputs["photos"] = {"xyz", 20};
  EXPECT_EQ(Difference(then, now), "input photos changed");
  now.inputs["photos"] = {"xyz", 21};
  EXPECT_EQ(Difference(then, now),
            "input photos changed (20 files -> 21 files)");
  now.inputs["photos"] = {"missing", 0};
  EXPECT_EQ(Difference(then, now), "input photos is missing");
  now.inputs.erase("photos");
  EXPECT_EQ(Difference(then, now), "input photos is no longer used");
  EXPECT_EQ(Difference(now, then), "input photos is new");
}

}  // namespace
}  // namespace freegs::pipeline
