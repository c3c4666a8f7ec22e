// SPDX-License-Identifier: BSD-3-Clause

#include "stages/run/time_choice.h"

#include <cstdlib>
#include <map>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "stages/registry/pipeline_options.h"
#include "stages/registry/presets.h"

namespace freegs::stages {
namespace {

using pipeline::OptionSetting;

std::map<std::string, std::string> ByName(
    const std::vector<OptionSetting>& settings) {
  std::map<std::string, std::string> values;
  for (const OptionSetting& setting : settings) {
    values[setting.name] = setting.value;
  }
  return values;
}

double Number(const std::string& text) {
  return std::strtod(text.c_str(), nullptr);
}

// Time in proportion to iterations and pixels, and 20 s for the cameras.
StatusOr<ExpectedRun> Foretold(const std::vector<OptionSetting>& settings) {
  const auto values = ByName(settings);
  const double side = Number(values.at("reconstruct.max_image_size"));
  return ExpectedRun{
      .cameras = 20,
      .others = 10 + 4e-8 * side * side *
                         Number(values.at("reconstruct.iterations"))};
}

TEST(TimeChoice, MoreTimeIsUsed) {
  double last = 0;
  for (const double seconds : {40.0, 60.0, 80.0, 100.0, 150.0, 400.0}) {
    const StatusOr<TimeChoice> choice = ChooseWithin(seconds, Foretold);
    ASSERT_TRUE(choice.ok());
    EXPECT_TRUE(choice->fits);
    EXPECT_LE(choice->expected.total(), seconds);
    EXPECT_GT(choice->expected.total(), 0.85 * seconds);
    EXPECT_GT(choice->expected.total(), last);
    last = choice->expected.total();
  }
}

TEST(TimeChoice, MoreTimeThanHelpsIsLeft) {
  const StatusOr<TimeChoice> choice = ChooseWithin(86400, Foretold);
  ASSERT_TRUE(choice.ok());
  const auto values = ByName(choice->settings);
  EXPECT_EQ(values.at("reconstruct.iterations"), "5000");
  EXPECT_EQ(values.at("reconstruct.max_image_size"), "1600");
}

// Here 3000 iterations at 1200 pixels are done and take no time, and any more
// would begin anew.
TEST(TimeChoice, WhatIsDoneIsTakenWhereMoreWouldTakeTooLong) {
  const auto foretell = [](const std::vector<OptionSetting>& settings) {
    const auto values = ByName(settings);
    const bool done = values.at("reconstruct.iterations") == "3000" &&
                      values.at("reconstruct.max_image_size") == "1200";
    return done ? StatusOr<ExpectedRun>(ExpectedRun()) : Foretold(settings);
  };
  StatusOr<TimeChoice> choice = ChooseWithin(60, foretell);
  ASSERT_TRUE(choice.ok());
  EXPECT_TRUE(choice->fits);
  EXPECT_EQ(choice->expected.total(), 0);
  EXPECT_EQ(ByName(choice->settings).at("reconstruct.iterations"), "3000");
  // With enough time for more there is more.
  choice = ChooseWithin(250, foretell);
  ASSERT_TRUE(choice.ok());
  EXPECT_LE(choice->expected.total(), 250);
  EXPECT_GT(choice->expected.total(), 200);
}

TEST(TimeChoice, TrainingIsToldInWords) {
  EXPECT_EQ(TrainingText({.iterations = 2300, .max_image_size = 800}),
            "2,300 iterations with images of up to 800 pixels");
  EXPECT_EQ(TrainingText({.iterations = 500}),
            "500 iterations with images of full size");
}

TEST(TimeChoice, WithoutTimeItIsTheShortest) {
  const StatusOr<TimeChoice> choice = ChooseWithin(1, Foretold);
  ASSERT_TRUE(choice.ok());
  EXPECT_FALSE(choice->fits);
  EXPECT_EQ(ByName(choice->settings).at("reconstruct.iterations"), "300");
}

TEST(TimeChoice, AllChoicesSetTheSameOptionsThatThereAre) {
  PipelineOptions options;
  pipeline::OptionTable table = MakeOptionTable(&options);
  std::vector<std::string> first;
  for (const double seconds : {1.0, 50.0, 100.0, 200.0, 300.0, 1000.0}) {
    const StatusOr<TimeChoice> choice = ChooseWithin(seconds, Foretold);
    ASSERT_TRUE(choice.ok());
    EXPECT_TRUE(table.Apply(choice->settings).ok());
    std::vector<std::string> names;
    for (const OptionSetting& setting : choice->settings) {
      names.push_back(setting.name);
    }
    if (first.empty()) first = names;
    EXPECT_EQ(names, first);
  }
}

// Where the time is what a preset takes, the choice is that preset.
TEST(TimeChoice, AgreesWithPresets) {
  const std::pair<const char*, double> kSeconds[] = {
      {"fast", 54.7}, {"balanced", 94.2}, {"quality", 86400}};
  for (const auto& [preset, seconds] : kSeconds) {
    PipelineOptions preset_options, chosen_options;
    pipeline::OptionTable preset_table = MakeOptionTable(&preset_options);
    pipeline::OptionTable chosen_table = MakeOptionTable(&chosen_options);
    ASSERT_TRUE(preset_table.Apply(*PresetSettings(preset)).ok());
    const StatusOr<TimeChoice> choice = ChooseWithin(seconds, Foretold);
    ASSERT_TRUE(choice.ok());
    ASSERT_TRUE(chosen_table.Apply(choice->settings).ok());
    for (const pipeline::OptionTable::Option& option : preset_table.options()) {
      EXPECT_EQ(chosen_table.Find(option.name)->value(), option.value())
          << preset << " " << option.name;
    }
  }
}

TEST(TimeChoice, ReturnsWhatCannotBeForetold) {
  const StatusOr<TimeChoice> choice =
      ChooseWithin(100, [](const auto&) -> StatusOr<ExpectedRun> {
        return BadInputError("no photos");
      });
  ASSERT_FALSE(choice.ok());
  EXPECT_EQ(choice.status().message(), "no photos");
}

}  // namespace
}  // namespace freegs::stages
