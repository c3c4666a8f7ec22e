// SPDX-License-Identifier: BSD-3-Clause
// Progress on a terminal and elsewhere, with a clock of the test's own.

#include "pipeline/progress_line.h"

#include <algorithm>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace freegs::pipeline {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

TEST(FormatProgressTest, ShowsShareSpeedAndTimeLeft) {
  EXPECT_EQ(FormatProgress({"training", 3200, 7000, "loss 0.03"}, 50),
            "training 3200/7000 45% 50.0/s 1 min 16 s left, loss 0.03");
  EXPECT_EQ(FormatProgress({"reading", 5, 0, ""}, 2), "reading 5 2.0/s");
  EXPECT_EQ(FormatProgress({"reading", 0, 10, ""}, 0), "reading 0/10 0%");
  EXPECT_EQ(FormatProgress({"reading", 10, 10, ""}, 0.05),
            "reading 10/10 100% 3.0/min");
  // Never "100%" before the end.
  EXPECT_THAT(FormatProgress({"x", 999, 1000, ""}, 0), HasSubstr(" 99%"));
}

TEST(ProgressLineTest, PlainLinesAreAtMostOnePerTenSecondsAndStep) {
  std::ostringstream console;
  Logger logger(console, /*terminal=*/false, "");
  double now = 0;
  {
    ProgressLine line(&logger, "sfm", {}, [&] { return now; });
    for (int i = 0; i <= 250; ++i) {
      now = 0.1 * i;
      line.Report({"matching", static_cast<double>(i), 250, ""});
    }
    line.Report({"mapping", 0, 10, ""});
  }
  const std::string text = console.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4) << text;
  EXPECT_THAT(text, HasSubstr("sfm: matching 0/250 0%\n"));
  EXPECT_THAT(text, HasSubstr("sfm: matching 100/250 40% 10.0/s 15 s left\n"));
  EXPECT_THAT(text, EndsWith("sfm: mapping 0/10 0%\n"));
  EXPECT_THAT(text, Not(HasSubstr("\r")));
}

TEST(ProgressRateTest, FollowsTheLastHalfMinute) {
  ProgressRate rate;
  for (int i = 0; i <= 100; ++i) rate.Update(i, {"x", 10.0 * i, 4000, ""});
  double last = 0;
  for (int i = 1; i <= 60; ++i) {
    last = rate.Update(100 + i, {"x", 1000.0 + 5 * i, 4000, ""});
  }
  EXPECT_NEAR(last, 5, 0.2);
}

// A mapper that places four photos a second, and then adjusts all for 80.
TEST(ProgressRateTest, PauseDoesNotMakeTheRestSeemEndless) {
  ProgressRate rate;
  for (int i = 0; i <= 240; ++i) rate.Update(0.25 * i, {"x", 1.0 * i, 292, ""});
  for (int i = 1; i < 80; ++i) rate.Update(60 + i, {"x", 240, 292, ""});
  EXPECT_NEAR(rate.Update(140, {"x", 241, 292, ""}), 0.24, 0.02);
}

TEST(ProgressLineTest, ResumedStepCountsOnlyWhatIsDoneNow) {
  std::ostringstream console;
  Logger logger(console, /*terminal=*/false, "");
  double now = 0;
  ProgressLine line(&logger, "r", {}, [&] { return now; });
  line.Report({"training", 5000, 7000, ""});
  now = 10;
  line.Report({"training", 5100, 7000, ""});
  EXPECT_THAT(console.str(), HasSubstr("10.0/s 3 min 10 s left"));
}

TEST(ProgressLineTest, RateFollowsAStepThatSlowsDown) {
  std::ostringstream console;
  Logger logger(console, /*terminal=*/false, "");
  double now = 0;
  double done = 0;
  ProgressLine line(&logger, "r", {}, [&] { return now; });
  for (; now < 100; now += 1) line.Report({"t", done += 100, 1e6, ""});
  for (; now < 145; now += 1) line.Report({"t", done += 1, 1e6, ""});
  const std::string text = console.str();
  const size_t last = text.rfind("r: t", text.size() - 2);
  EXPECT_THAT(text.substr(last), HasSubstr(" 1.0/s"));
}

TEST(ProgressLineTest, TellsWhatIsLeftForTheWholeRun) {
  std::ostringstream console;
  Logger logger(console, /*terminal=*/false, "");
  double now = 100;
  const auto last = [&console] {
    const std::string text = console.str();
    return text.substr(text.rfind("r (", text.size() - 2));
  };
  ProgressLine line(
      &logger, "r", {.stage = 60, .later = 30}, [&] { return now; });
  line.Report({"reading", 0, 0, ""});
  EXPECT_EQ(last(), "r (1 min 30 s left for all): reading 0\n");
  now += 20;
  line.Report({"training", 0, 100, ""});
  EXPECT_EQ(last(), "r (1 min 10 s left for all): training 0/100 0%\n");
  // Slower than expected: 80 s are left of this step, and 30 s of later stages.
  now += 20;
  line.Report({"training", 20, 100, ""});
  EXPECT_THAT(last(), StartsWith("r (1 min 50 s left for all): training 20/"));
  // Longer than expected, and no step says how long it will last.
  now += 100;
  line.Report({"writing", 0, 0, ""});
  EXPECT_THAT(last(), StartsWith("r (30 s left for all): writing"));
}

TEST(ProgressLineTest, TerminalLineIsDrawnOverAndErased) {
  std::ostringstream console;
  Logger logger(console, /*terminal=*/true, "");
  double now = 0;
  {
    ProgressLine line(&logger, "sfm", {}, [&] { return now; });
    line.Report({"matching", 1, 10, ""});
    now = 0.05;  // Too soon to be drawn again.
    line.Report({"matching", 2, 10, ""});
    now = 0.2;
    line.Report({"matching", 3, 10, std::string(500, 'x')});
    logger.Log(LogLevel::kWarning, "a message");
    now = 0.4;
    line.Report({"matching", 4, 10, ""});
  }
  const std::string text = console.str();
  EXPECT_THAT(text, HasSubstr("\r\x1b[Ksfm: matching 1/10"));
  EXPECT_THAT(text, Not(HasSubstr("matching 2/10")));
  EXPECT_THAT(text, HasSubstr("\r\x1b[Kwarning: a message\n"));
  EXPECT_THAT(text, EndsWith("\r\x1b[K"));
  EXPECT_LT(text.size(), 600u);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
}

TEST(LoggerTest, FileGetsTimeAndLevel) {
  const TemporaryFolder folder;
  std::ostringstream console;
  for (int i = 0; i < 2; ++i) {
    Logger logger(console, /*terminal=*/false, folder / "log.txt");
    logger.Log(LogLevel::kInfo, "hello");
    logger.LogToFile(LogLevel::kError, "quiet");
    logger.SetTransient("never without a terminal");
  }
  EXPECT_EQ(console.str(), "hello\nhello\n");
  const std::string text = ReadText(folder / "log.txt");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4);
  EXPECT_THAT(text, HasSubstr("Z error: quiet\n"));
}

TEST(LoggerTest, UnwritableFileIsLeftOut) {
  std::ostringstream console;
  Logger logger(console, /*terminal=*/false, "/no/such/folder/log.txt");
  logger.Log(LogLevel::kInfo, "hello");
  EXPECT_EQ(console.str(), "hello\n");
}

}  // namespace
}  // namespace freegs::pipeline
