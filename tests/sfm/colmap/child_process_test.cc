// SPDX-License-Identifier: BSD-3-Clause
// Running programs: output, exit codes, cancellation, and no survivors.

#include "sfm/colmap/child_process.h"

#include <chrono>
#include <csignal>
#include <fstream>
#include <sstream>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/files.h"
#include "tests/temporary_folder.h"

namespace freegs::sfm {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

ChildCommand Shell(const std::string& script) {
  return {{"/bin/sh", "-c", script}, {}, {}};
}

TEST(RunChild, ReadsLinesOfBothStreams) {
  std::vector<std::string> lines;
  const auto result = RunChild(
      Shell("echo one; echo two >&2; printf 'three\\rfour\\n\\nfive'"),
      [&](std::string_view line) { lines.emplace_back(line); },
      nullptr);
  ASSERT_TRUE(result.ok());
  EXPECT_TRUE(result->ok());
  EXPECT_THAT(lines, ElementsAre("one", "two", "three", "four", "five"));
  EXPECT_THAT(result->tail, HasSubstr("five\n"));
}

TEST(RunChild, ArgumentsAndEnvironmentArriveUnchanged) {
  std::vector<std::string> lines;
  ChildCommand command = Shell("printf '%s\\n' \"$1\" \"$2\" \"$FREEGS_TEST\"");
  command.argv.insert(command.argv.end(),
                      {"sh", "a b; echo 'x' $HOME", "\"ü\""});
  command.environment = {{"FREEGS_TEST", "some value"}};
  ASSERT_TRUE(RunChild(
                  command,
                  [&](std::string_view line) { lines.emplace_back(line); },
                  nullptr)
                  .ok());
  EXPECT_THAT(lines, ElementsAre("a b; echo 'x' $HOME", "\"ü\"", "some value"));
}

TEST(RunChild, EndsWhenItsTimeIsOver) {
  ChildCommand command = Shell("echo begun; sleep 100 & sleep 100");
  command.time_limit_s = 0.3;
  const auto start = std::chrono::steady_clock::now();
  const auto result = RunChild(command, {}, nullptr);
  ASSERT_TRUE(result.ok());
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
  EXPECT_FALSE(result->ok());
  EXPECT_TRUE(result->timed_out);
  EXPECT_THAT(result->Describe(), HasSubstr("no end within"));
  EXPECT_EQ(result->tail, "begun\n");
  command = Shell("true");
  command.time_limit_s = 60;
  EXPECT_TRUE(RunChild(command, {}, nullptr)->ok());
}

TEST(RunChild, ReportsExitCodeAndSignal) {
  const auto failed = RunChild(Shell("echo why; exit 3"), {}, nullptr);
  ASSERT_TRUE(failed.ok());
  EXPECT_EQ(failed->exit_code, 3);
  EXPECT_THAT(failed->Describe(), HasSubstr("3"));
  EXPECT_EQ(failed->tail, "why\n");
  const auto crashed = RunChild(Shell("kill -SEGV $$"), {}, nullptr);
  ASSERT_TRUE(crashed.ok());
  EXPECT_EQ(crashed->signal, SIGSEGV);
  EXPECT_FALSE(crashed->ok());
  EXPECT_THAT(crashed->Describe(), HasSubstr("signal 11"));
}

// Sets what this process does on SIGCHLD while it lives.
class ChildSignal {
 public:
  explicit ChildSignal(void (*handler)(int))
      : before_(std::signal(SIGCHLD, handler)) {}
  ~ChildSignal() { std::signal(SIGCHLD, before_); }
  ChildSignal(const ChildSignal&) = delete;
  ChildSignal& operator=(const ChildSignal&) = delete;

 private:
  void (*before_)(int);
};

// As a process that was started after "trap '' CHLD" does.
TEST(RunChild, TellsTheExitCodeThoughThisProcessIgnoresItsChildren) {
  const ChildSignal ignored(SIG_IGN);
  const auto failed = RunChild(Shell("exit 3"), {}, nullptr);
  ASSERT_TRUE(failed.ok());
  EXPECT_EQ(failed->exit_code, 3);
}

TEST(RunChild, AnUnknownEndIsNoSuccess) {
  const ChildSignal usual(SIG_DFL);
  const auto result = RunChild(
      Shell("echo begun; sleep 0.3"),
      [](std::string_view) { std::signal(SIGCHLD, SIG_IGN); },
      nullptr);
  ASSERT_TRUE(result.ok());
  EXPECT_FALSE(result->ok());
  EXPECT_EQ(result->signal, 0);
  EXPECT_THAT(result->Describe(), HasSubstr("unknown"));
}

TEST(RunChild, MissingProgram) {
  const auto result = RunChild({{"/nonexistent/program"}, {}, {}}, {}, nullptr);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.status().code(), StatusCode::kMissingDependency);
  EXPECT_THAT(result.status().message(), HasSubstr("/nonexistent/program"));
}

TEST(RunChild, EmptyInput) {
  const auto result = RunChild(Shell("cat; exit 7"), {}, nullptr);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->exit_code, 7);
}

TEST(RunChild, KeepsALog) {
  const TemporaryFolder folder;
  ChildCommand command = Shell("echo first");
  command.log_file = folder.path() / "log.txt";
  ASSERT_TRUE(RunChild(command, {}, nullptr).ok());
  command.argv.back() = "echo second";
  ASSERT_TRUE(RunChild(command, {}, nullptr).ok());
  EXPECT_EQ(*ReadFile(command.log_file), "first\nsecond\n");
}

TEST(RunChild, ALotOfOutputWithoutLineEnds) {
  size_t total = 0;
  const auto result = RunChild(
      Shell("head -c 3000000 /dev/zero | tr '\\0' x"),
      [&](std::string_view line) { total += line.size(); },
      nullptr);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(total, 3000000u);
}

// A process that left the group keeps the pipe open, so the output of the
// program that ended has no end.
TEST(RunChild, LastWordsArriveThoughThePipeStaysOpen) {
  pid_t stray = 0;
  std::vector<std::string> lines;
  const auto result = RunChild(
      Shell("setsid sleep 100 & echo $!; printf 'last words'; exit 5"),
      [&](std::string_view line) {
        if (stray == 0) stray = std::stoi(std::string(line));
        lines.emplace_back(line);
      },
      nullptr);
  if (stray > 0) kill(stray, SIGKILL);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->exit_code, 5);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[1], "last words");
  EXPECT_THAT(result->tail, HasSubstr("last words\n"));
}

// Waits until a process is gone (a zombie that init has not reaped counts).
bool Vanishes(pid_t pid) {
  for (int i = 0; i < 200; ++i) {
    std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
    std::string id, name, state;
    if (!(stat >> id >> name >> state) || state == "Z") return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
  return false;
}

TEST(RunChild, CancellationEndsTheWholeGroup) {
  CancellationToken token;
  std::vector<pid_t> pids;
  // The shell ignores SIGTERM, and so does its child.
  const auto result = RunChild(
      Shell("trap '' TERM; sleep 100 & echo $!; echo $$; wait; sleep 100"),
      [&](std::string_view line) {
        pids.push_back(std::stoi(std::string(line)));
        if (pids.size() == 2) token.Cancel();
      },
      &token);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.status().code(), StatusCode::kInterrupted);
  ASSERT_EQ(pids.size(), 2u);
  for (const pid_t pid : pids) EXPECT_TRUE(Vanishes(pid));
}

// As when colmap is a script that starts the program.
TEST(RunChild, TheGroupDiesWhenTheParentIsKilled) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const pid_t parent = fork();
  ASSERT_GE(parent, 0);
  if (parent == 0) {
    (void)RunChild(
        Shell("trap '' INT TERM; sleep 100 & echo $! $$; wait"),
        [&](std::string_view line) {
          [[maybe_unused]] const ssize_t written =
              write(ends[1], line.data(), line.size());
        },
        nullptr);
    _exit(0);
  }
  close(ends[1]);
  char text[64] = {};
  ASSERT_GT(read(ends[0], text, sizeof(text) - 1), 0);
  close(ends[0]);
  pid_t grandchild = 0;
  pid_t child = 0;
  ASSERT_TRUE(std::istringstream(text) >> grandchild >> child);
  EXPECT_EQ(kill(child, 0), 0);
  EXPECT_EQ(kill(grandchild, 0), 0);
  kill(parent, SIGKILL);
  waitpid(parent, nullptr, 0);
  EXPECT_TRUE(Vanishes(child));
  EXPECT_TRUE(Vanishes(grandchild));
}

TEST(RunChild, LeavesNothingOfTheGroup) {
  pid_t grandchild = 0;
  const auto result = RunChild(
      Shell("sleep 100 & echo $!"),
      [&](std::string_view line) { grandchild = std::stoi(std::string(line)); },
      nullptr);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->exit_code, 0);
  EXPECT_TRUE(Vanishes(grandchild));
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);  // Nor of its guard.
}

TEST(RunChildren, RunsAllSeveralAtATime) {
  ChildBatch batch;
  batch.count = 7;
  batch.max_parallel = 3;
  std::vector<size_t> prepared;
  std::vector<int> codes(7, -1);
  std::vector<std::string> lines(7);
  batch.prepare = [&](size_t i) -> StatusOr<ChildCommand> {
    prepared.push_back(i);
    return Shell("echo line " + std::to_string(i) + "; exit " +
                 std::to_string(i));
  };
  batch.finished = [&](size_t i, const ChildResult& result) {
    codes[i] = result.exit_code;
    return Status();
  };
  batch.on_line = [&](size_t i, std::string_view line) { lines[i] += line; };
  ASSERT_TRUE(RunChildren(batch, nullptr).ok());
  EXPECT_THAT(prepared, ElementsAre(0, 1, 2, 3, 4, 5, 6));
  EXPECT_THAT(codes, ElementsAre(0, 1, 2, 3, 4, 5, 6));
  for (size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(lines[i], "line " + std::to_string(i));
  }
}

TEST(RunChildren, AnErrorEndsTheOthers) {
  ChildBatch batch;
  batch.count = 5;
  batch.max_parallel = 2;
  batch.prepare = [&](size_t i) -> StatusOr<ChildCommand> {
    return Shell(i == 0 ? "exit 1" : "sleep 100");
  };
  batch.finished = [&](size_t, const ChildResult& result) {
    return result.ok() ? Status() : UnusableResultError("failed");
  };
  const Status status = RunChildren(batch, nullptr);
  EXPECT_EQ(status.code(), StatusCode::kUnusableResult);
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);  // No child is left.
}

}  // namespace
}  // namespace freegs::sfm
