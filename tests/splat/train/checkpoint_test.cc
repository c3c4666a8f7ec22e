// SPDX-License-Identifier: BSD-3-Clause
// Everything comes back; nothing damaged is believed.

#include "splat/train/checkpoint.h"

#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/files.h"
#include "tests/splat/random_model.h"
#include "tests/temporary_folder.h"

namespace freegs::splat {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::SizeIs;

TrainingCheckpoint Example(int64_t iteration, size_t count = 12) {
  TrainingCheckpoint checkpoint;
  checkpoint.iteration = iteration;
  checkpoint.elapsed_seconds = 12.25;
  checkpoint.model = RandomModel(count, 2, 1);
  checkpoint.adam.steps = 77;
  checkpoint.adam.first_moments = RandomModel(count, 2, 2);
  checkpoint.adam.second_moments = RandomModel(count, 2, 3);
  checkpoint.statistics.Reset(count);
  for (size_t i = 0; i < count; ++i) {
    checkpoint.statistics.gradient_sum[i] = 0.5f * static_cast<float>(i);
    checkpoint.statistics.visible_steps[i] = static_cast<uint32_t>(3 * i);
    checkpoint.statistics.max_dominant_share[i] = 0.01f * static_cast<float>(i);
  }
  checkpoint.history.milestones = {
      {1, TrainingEvent::kDepthReinitialization, 5, 9},
      {2, TrainingEvent::kPruning, 12, 11}};
  checkpoint.history.recoveries = {{33, "the loss rose", 30, 0.5}};
  checkpoint.history.rate_factor = 0.5;
  checkpoint.history.loss = {40, 0.25, 0.125};
  checkpoint.history.exposure_choice = {true, {25.5, 27}, {26.25, 28}};
  checkpoint.history.colors.entries.resize(3);
  for (int i = 0; i < 12; ++i) {
    PhotoColors::Entry& entry = checkpoint.history.colors.entries[1];
    entry.color.values[i] = 0.5f * static_cast<float>(i);
    entry.first_moment[i] = -0.25f * static_cast<float>(i);
    entry.second_moment[i] = static_cast<float>(i);
    entry.steps = 17;
  }
  checkpoint.history.last_good = {
      iteration / 2, RandomModel(count + 3, 1, 4), checkpoint.history.colors};
  checkpoint.history.last_good->colors.entries[2].color.values[4] = 0.75f;
  checkpoint.history.average = {7, RandomModel(count, 2, 5)};
  checkpoint.facts = {{"best_psnr", "25.75"}, {"empty", ""}};
  return checkpoint;
}

void ExpectSame(const TrainingCheckpoint& a, const TrainingCheckpoint& b) {
  EXPECT_EQ(a.iteration, b.iteration);
  EXPECT_EQ(a.elapsed_seconds, b.elapsed_seconds);
  EXPECT_TRUE(SameParameters(a.model, b.model));
  EXPECT_EQ(a.adam.steps, b.adam.steps);
  EXPECT_TRUE(SameParameters(a.adam.first_moments, b.adam.first_moments));
  EXPECT_TRUE(SameParameters(a.adam.second_moments, b.adam.second_moments));
  EXPECT_EQ(a.statistics.gradient_sum, b.statistics.gradient_sum);
  EXPECT_EQ(a.statistics.visible_steps, b.statistics.visible_steps);
  EXPECT_EQ(a.statistics.max_dominant_share, b.statistics.max_dominant_share);
  EXPECT_EQ(a.history.milestones, b.history.milestones);
  EXPECT_EQ(a.history.recoveries, b.history.recoveries);
  EXPECT_EQ(a.history.rate_factor, b.history.rate_factor);
  EXPECT_EQ(a.history.loss, b.history.loss);
  EXPECT_EQ(a.history.exposure_choice, b.history.exposure_choice);
  EXPECT_EQ(a.history.colors, b.history.colors);
  ASSERT_EQ(a.history.last_good.has_value(), b.history.last_good.has_value());
  if (a.history.last_good) {
    EXPECT_EQ(a.history.last_good->iteration, b.history.last_good->iteration);
    EXPECT_TRUE(
        SameParameters(a.history.last_good->model, b.history.last_good->model));
    EXPECT_EQ(a.history.last_good->colors, b.history.last_good->colors);
  }
  EXPECT_EQ(a.history.average.count, b.history.average.count);
  EXPECT_TRUE(SameParameters(a.history.average.mean, b.history.average.mean));
  EXPECT_EQ(a.facts, b.facts);
}

// The hash of changed content, so that the parser behind it is reached.
std::string Resealed(std::string content) {
  content.resize(content.size() - 32);
  return content + HashBytes(content);
}

class CheckpointFolderTest : public ::testing::Test {
 protected:
  const TemporaryFolder temporary_;
  const fs::path folder_ = temporary_ / "checkpoints";  // Not there yet.
};

TEST(CheckpointTest, RoundTrip) {
  const TrainingCheckpoint checkpoint = Example(4200);
  const StatusOr<TrainingCheckpoint> read =
      ParseCheckpoint(SerializeCheckpoint(checkpoint));
  ASSERT_TRUE(read.ok()) << read.status().message();
  ExpectSame(checkpoint, *read);
}

TEST(CheckpointTest, EmptyRoundTrip) {
  const StatusOr<TrainingCheckpoint> read =
      ParseCheckpoint(SerializeCheckpoint(TrainingCheckpoint()));
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_TRUE(read->model.empty());
}

TEST(CheckpointTest, EveryTruncationIsRefused) {
  const std::string content = SerializeCheckpoint(Example(1, 2));
  for (size_t size = 0; size < content.size(); ++size) {
    const StatusOr<TrainingCheckpoint> read =
        ParseCheckpoint(content.substr(0, size));
    ASSERT_FALSE(read.ok()) << size;
    ASSERT_EQ(read.status().code(), StatusCode::kBadInput);
  }
  EXPECT_FALSE(ParseCheckpoint(content + "x").ok());
}

TEST(CheckpointTest, EveryFlippedByteIsRefused) {
  const std::string content = SerializeCheckpoint(Example(1, 2));
  for (size_t at = 0; at < content.size(); ++at) {
    std::string damaged = content;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    ASSERT_FALSE(ParseCheckpoint(damaged).ok()) << at;
  }
}

// With a right checksum the parser itself must stand its ground.
TEST(CheckpointTest, SurvivesHostileContentWithRightChecksum) {
  const std::string content = SerializeCheckpoint(Example(1, 2));
  for (size_t at = 0; at + 32 < content.size(); ++at) {
    std::string hostile = content;
    hostile[at] = '\xff';
    const StatusOr<TrainingCheckpoint> read =
        ParseCheckpoint(Resealed(hostile));
    if (!read.ok()) {
      ASSERT_EQ(read.status().code(), StatusCode::kBadInput);
    }
    std::string cut = content.substr(0, at) + content.substr(0, 32);
    if (at > 12) {
      EXPECT_FALSE(ParseCheckpoint(Resealed(cut)).ok()) << at;
    }
  }
}

TEST(CheckpointTest, OtherVersionsAreNamed) {
  std::string content = SerializeCheckpoint(Example(1, 2));
  content[8] = 9;
  EXPECT_THAT(ParseCheckpoint(Resealed(content)).status().message(),
              HasSubstr("format 9"));
  content[8] = 4;  // Before there was exposure.
  EXPECT_THAT(ParseCheckpoint(Resealed(content)).status().message(),
              HasSubstr("format 4"));
  content[8] = 1;  // Before there was max_dominant_share.
  const Status old = ParseCheckpoint(Resealed(content)).status();
  EXPECT_EQ(old.code(), StatusCode::kBadInput);
  EXPECT_THAT(old.message(), HasSubstr("format 1, this program reads 8"));
}

TEST(CheckpointTest, ArraysMustFitTheModel) {
  TrainingCheckpoint checkpoint = Example(1);
  checkpoint.adam.second_moments = RandomModel(11, 2, 3);
  EXPECT_FALSE(ParseCheckpoint(SerializeCheckpoint(checkpoint)).ok());
  checkpoint = Example(1);
  checkpoint.adam.first_moments = RandomModel(12, 1, 3);
  EXPECT_FALSE(ParseCheckpoint(SerializeCheckpoint(checkpoint)).ok());
  checkpoint = Example(1);
  checkpoint.statistics.Reset(13);
  EXPECT_FALSE(ParseCheckpoint(SerializeCheckpoint(checkpoint)).ok());
}

TEST(CheckpointTest, HistoryMustMakeSense) {
  const auto read = [](const TrainingCheckpoint& checkpoint) {
    return ParseCheckpoint(SerializeCheckpoint(checkpoint)).ok();
  };
  TrainingCheckpoint checkpoint = Example(100);
  checkpoint.history.last_good.reset();
  EXPECT_TRUE(read(checkpoint));
  checkpoint = Example(100);
  checkpoint.history.last_good->iteration = 101;  // Ahead of the model.
  EXPECT_FALSE(read(checkpoint));
  checkpoint.history.last_good->iteration = -1;
  EXPECT_FALSE(read(checkpoint));
  for (const double factor : {0.0, -1.0, 2.0, std::nan("")}) {
    checkpoint = Example(100);
    checkpoint.history.rate_factor = factor;
    EXPECT_FALSE(read(checkpoint)) << factor;
  }
  checkpoint = Example(100);
  checkpoint.history.loss.sum = INFINITY;
  EXPECT_FALSE(read(checkpoint));
  checkpoint = Example(100);
  checkpoint.history.milestones[0].event = static_cast<TrainingEvent>(3);
  EXPECT_FALSE(read(checkpoint));
}

TEST(CheckpointTest, ColoursMustMakeSense) {
  const auto read = [](const TrainingCheckpoint& checkpoint) {
    const StatusOr<TrainingCheckpoint> back =
        ParseCheckpoint(SerializeCheckpoint(checkpoint));
    if (back.ok()) ExpectSame(checkpoint, *back);
    return back.ok();
  };
  TrainingCheckpoint checkpoint = Example(100);
  checkpoint.history.exposure_choice.reset();
  EXPECT_TRUE(read(checkpoint));
  checkpoint.history.colors.entries.clear();
  EXPECT_TRUE(read(checkpoint));
  checkpoint = Example(100);
  checkpoint.history.colors.entries[2].color.values[5] = std::nanf("");
  EXPECT_FALSE(read(checkpoint));
  checkpoint = Example(100);
  checkpoint.history.colors.entries[2].steps = -1;
  EXPECT_FALSE(read(checkpoint));
  checkpoint = Example(100);
  checkpoint.history.last_good->colors.entries[0].steps = -1;
  EXPECT_FALSE(read(checkpoint));
}

TEST_F(CheckpointFolderTest, KeepsTheNewestAndClearsUp) {
  ASSERT_TRUE(CreateFolders(folder_).ok());
  const fs::path stale = folder_ / "iteration_00000050.ckpt.part";
  const fs::path foreign = folder_ / "notes.txt";
  ASSERT_TRUE(WriteFileAtomic(stale, "half").ok());
  ASSERT_TRUE(WriteFileAtomic(foreign, "mine").ok());
  for (const int64_t iteration : {100, 200, 300, 123456789}) {
    ASSERT_TRUE(SaveCheckpoint(folder_, ViewOf(Example(iteration))).ok());
  }
  EXPECT_FALSE(fs::exists(stale));
  EXPECT_TRUE(fs::exists(foreign));
  EXPECT_TRUE(fs::exists(folder_ / "iteration_00000300.ckpt"));
  EXPECT_TRUE(fs::exists(folder_ / "iteration_123456789.ckpt"));
  EXPECT_FALSE(fs::exists(folder_ / "iteration_00000200.ckpt"));
  const std::optional<TrainingCheckpoint> latest = LatestCheckpoint(folder_);
  ASSERT_TRUE(latest.has_value());
  ExpectSame(*latest, Example(123456789));
}

TEST_F(CheckpointFolderTest, WhatATrainingThatWentBackHasLeftIsRemoved) {
  for (const int64_t iteration : {100, 200, 300, 250}) {
    ASSERT_TRUE(SaveCheckpoint(folder_, ViewOf(Example(iteration))).ok());
  }
  EXPECT_TRUE(fs::exists(folder_ / "iteration_00000200.ckpt"));
  EXPECT_FALSE(fs::exists(folder_ / "iteration_00000300.ckpt"));
  const std::optional<TrainingCheckpoint> latest = LatestCheckpoint(folder_);
  ASSERT_TRUE(latest.has_value());
  EXPECT_EQ(latest->iteration, 250);
}

TEST_F(CheckpointFolderTest, FallsBackToTheNewestThatIsWhole) {
  ASSERT_TRUE(SaveCheckpoint(folder_, ViewOf(Example(100))).ok());
  ASSERT_TRUE(SaveCheckpoint(folder_, ViewOf(Example(200))).ok());
  ASSERT_TRUE(WriteFileAtomic(folder_ / "iteration_00000200.ckpt",
                              SerializeCheckpoint(Example(200)).substr(0, 99))
                  .ok());
  std::vector<std::string> problems;
  const std::optional<TrainingCheckpoint> latest =
      LatestCheckpoint(folder_, &problems);
  ASSERT_TRUE(latest.has_value());
  EXPECT_EQ(latest->iteration, 100);
  ASSERT_THAT(problems, SizeIs(1));
  EXPECT_THAT(problems[0], HasSubstr("iteration_00000200.ckpt"));
}

TEST_F(CheckpointFolderTest, NoFolderOrNothingInIt) {
  EXPECT_FALSE(LatestCheckpoint(folder_).has_value());
  ASSERT_TRUE(CreateFolders(folder_ / "iteration_00000001.ckpt").ok());
  EXPECT_FALSE(LatestCheckpoint(folder_).has_value());
}

}  // namespace
}  // namespace freegs::splat
