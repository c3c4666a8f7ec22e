// SPDX-License-Identifier: BSD-3-Clause
// Which signals stop a run, and which do not.

#include "pipeline/interrupt.h"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

namespace freegs::pipeline {
namespace {

TEST(InterruptGuardTest, SignalsCancel) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    CancellationToken token;
    const InterruptGuard guard(&token, /*checkpoint=*/true);
    EXPECT_FALSE(token.cancelled());
    std::raise(signal);
    EXPECT_TRUE(token.cancelled()) << signal;
  }
}

TEST(InterruptGuardTest, ALaterSignalEndsTheProgram) {
  const auto twice = [](bool checkpoint) {
    CancellationToken token;
    const InterruptGuard guard(&token, checkpoint);
    std::raise(SIGHUP);
    std::this_thread::sleep_for(std::chrono::milliseconds(1050));
    std::raise(SIGINT);
  };
  EXPECT_EXIT(twice(true), testing::ExitedWithCode(130), "with a checkpoint");
  EXPECT_EXIT(twice(false), testing::ExitedWithCode(130), "stopping \\(again");
}

// As from the program `timeout`, which sends its signal to the process and to
// the group of the process.
TEST(InterruptGuardTest, ASignalThatIsSentTwiceIsOne) {
  for (int i = 0; i < 2; ++i) {
    CancellationToken token;
    const InterruptGuard guard(&token, /*checkpoint=*/true);
    std::raise(SIGTERM);
    std::raise(SIGTERM);
    EXPECT_TRUE(token.cancelled());
  }
}

// As under nohup.
TEST(InterruptGuardTest, AnIgnoredHangUpStaysIgnored) {
  const auto old = std::signal(SIGHUP, SIG_IGN);
  CancellationToken token;
  {
    const InterruptGuard guard(&token, /*checkpoint=*/true);
    std::raise(SIGHUP);
  }
  EXPECT_FALSE(token.cancelled());
  EXPECT_EQ(std::signal(SIGHUP, old), SIG_IGN);
}

TEST(InterruptGuardTest, OutputWithoutReaderIsNoEnd) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  close(ends[0]);
  CancellationToken token;
  {
    const InterruptGuard guard(&token, /*checkpoint=*/true);
    EXPECT_EQ(write(ends[1], "a", 1), -1);
    EXPECT_EQ(errno, EPIPE);
  }
  close(ends[1]);
  EXPECT_FALSE(token.cancelled());
  EXPECT_EQ(std::signal(SIGPIPE, SIG_DFL), SIG_DFL);
}

}  // namespace
}  // namespace freegs::pipeline
