// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/field_checkpoint.h"

#include <cstdint>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "core/io/files.h"
#include "tests/temporary_folder.h"

namespace freegs::semantics {
namespace {

FieldState SmallState() {
  FieldTrainingOptions options;
  options.hidden_dim = 3;
  FieldState state =
      FieldTraining::InitialState({1, 2, 3, 4, 5, 6}, 2, 4, options, 7);
  state.step = 42;
  state.teachers = {2, {0, -1, 1}, {1, 0, 0, 0, 0, 0, 0, 0}};
  state.rounds = {{30, 2, 0}, {40, 2, 0.75}};
  state.history = {{40, {0.1, 0.2, 0.3, 0.4}}};
  state.sums.pixel = 0.5;
  state.counts.pixel = 2;
  return state;
}

TEST(FieldCheckpointTest, ComesBackWhole) {
  TemporaryFolder folder;
  const FieldState state = SmallState();
  ASSERT_TRUE(WriteFieldState(folder / "field.ckpt", state).ok());
  const auto read = ReadFieldState(folder / "field.ckpt");
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(*SerializeFieldState(*read), *SerializeFieldState(state));
  EXPECT_EQ(read->step, 42);
  EXPECT_EQ(read->teachers.labels, state.teachers.labels);
  EXPECT_EQ(read->rounds[1].agreement, 0.75);
  EXPECT_EQ(read->history[0].losses.contrastive, 0.4);
  EXPECT_EQ(read->counts.pixel, 2);
}

TEST(FieldCheckpointTest, TakesNoMoreMemoryThanItsBytes) {
  FieldState state = SmallState();
  for (std::vector<float>* array : {&state.features,
                                    &state.feature_adam.first_moments,
                                    &state.feature_adam.second_moments}) {
    array->resize(10000);
  }
  state.teachers.labels.resize(5000);
  state.rounds.resize(1000);
  state.history.resize(1000);
  const auto bytes = SerializeFieldState(state);
  ASSERT_TRUE(bytes.ok());
  EXPECT_LT(bytes->capacity(), 1.1 * bytes->size());
}

TEST(FieldCheckpointTest, DamageIsFound) {
  const std::string bytes = *SerializeFieldState(SmallState());
  for (size_t size = 0; size < bytes.size(); size += 7) {
    EXPECT_EQ(ParseFieldState(bytes.substr(0, size)).status().code(),
              StatusCode::kBadInput);
  }
  for (size_t at = 0; at < bytes.size(); at += 5) {
    std::string damaged = bytes;
    damaged[at] ^= 0x20;
    EXPECT_EQ(ParseFieldState(damaged).status().code(), StatusCode::kBadInput);
  }
  EXPECT_EQ(ParseFieldState(bytes + bytes).status().code(),
            StatusCode::kBadInput);
}

TEST(FieldCheckpointTest, PartsThatDoNotFitAreRefused) {
  const auto refused = [](const FieldState& state) {
    const auto bytes = SerializeFieldState(state);
    return !bytes.ok() || !ParseFieldState(*bytes).ok();
  };
  EXPECT_FALSE(refused(SmallState()));
  FieldState state = SmallState();
  state.features.push_back(0);
  EXPECT_TRUE(refused(state));
  state = SmallState();
  state.teachers.labels[0] = 2;
  EXPECT_TRUE(refused(state));
  state = SmallState();
  state.teachers.vectors.pop_back();
  EXPECT_TRUE(refused(state));
  state = SmallState();
  state.feature_adam.first_moments.clear();
  EXPECT_TRUE(refused(state));
  state = SmallState();
  state.features[1] = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(refused(state));
}

TEST(FieldCheckpointTest, NumbersThatAreNotAdamsAreRefused) {
  const auto refused = [](const auto& change) {
    FieldState state = SmallState();
    change(state.feature_adam);
    const auto bytes = SerializeFieldState(state);
    return bytes.ok() &&
           ParseFieldState(*bytes).status().code() == StatusCode::kBadInput;
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr int64_t kMostSteps = int64_t{1} << 53;
  EXPECT_FALSE(refused([](ArrayAdamState& adam) { adam.steps = kMostSteps; }));
  EXPECT_TRUE(
      refused([](ArrayAdamState& adam) { adam.steps = kMostSteps + 1; }));
  EXPECT_TRUE(refused([](ArrayAdamState& adam) { adam.steps = INT64_MAX; }));
  EXPECT_TRUE(refused([](ArrayAdamState& adam) { adam.steps = -1; }));
  EXPECT_TRUE(
      refused([](ArrayAdamState& adam) { adam.first_moments[2] = kNan; }));
  EXPECT_TRUE(
      refused([](ArrayAdamState& adam) { adam.second_moments[2] = kNan; }));
  EXPECT_TRUE(
      refused([](ArrayAdamState& adam) { adam.second_moments[2] = -1; }));
}

TEST(FieldCheckpointTest, NamesTheFile) {
  TemporaryFolder folder;
  const auto missing = ReadFieldState(folder / "none.ckpt");
  ASSERT_FALSE(missing.ok());
  EXPECT_NE(missing.status().message().find("none.ckpt"), std::string::npos);
  ASSERT_TRUE(WriteFileAtomic(folder / "bad.ckpt", "FREEGSFT").ok());
  const auto bad = ReadFieldState(folder / "bad.ckpt");
  ASSERT_FALSE(bad.ok());
  EXPECT_NE(bad.status().message().find("bad.ckpt"), std::string::npos);
}

}  // namespace
}  // namespace freegs::semantics
