// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/view_command.h"

#include <chrono>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/stages/view/view_fixture.h"

namespace freegs::stages {
namespace {

using testing::HasSubstr;

// What one thread writes and another reads.
class SharedText : public std::stringbuf {
 public:
  std::string Text() {
    const std::lock_guard lock(mutex_);
    return str();
  }

 private:
  std::streamsize xsputn(const char* bytes, std::streamsize count) override {
    const std::lock_guard lock(mutex_);
    return std::stringbuf::xsputn(bytes, count);
  }
  int overflow(int byte) override {
    const std::lock_guard lock(mutex_);
    return std::stringbuf::overflow(byte);
  }

  std::recursive_mutex mutex_;  // xsputn calls overflow.
};

struct RunningView {
  // Begins the command and waits for the line with its address.
  explicit RunningView(std::vector<std::string> arguments)
      : thread([this, arguments] {
          CommandContext context{out, err, cancellation, ""};
          status = RunViewCommand(arguments, context);
        }) {
    for (int i = 0; i < 500 && text.Text().find('\n') == std::string::npos;
         ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  ~RunningView() {
    cancellation.Cancel();
    if (thread.joinable()) thread.join();
  }

  CancellationToken cancellation;
  SharedText text;
  std::ostream out{&text};
  std::ostringstream err;
  Status status;
  std::thread thread;
};

TEST(ViewCommand, ServesUntilItIsCancelled) {
  const SyntheticWorkspace workspace;
  RunningView view({workspace.path().string(), "--port", "0"});
  const std::string line = view.text.Text();
  ASSERT_THAT(line, HasSubstr("view: http://127.0.0.1:"));
  EXPECT_TRUE(line.ends_with("/\n")) << line;
  const int port = std::atoi(line.c_str() + line.rfind(':') + 1);
  const RawClient client(port);
  client.Send("GET /api/status HTTP/1.1\r\nHost: 127.0.0.1:" +
              std::to_string(port) + "\r\n\r\n");
  EXPECT_THAT(client.Receive(), HasSubstr("\"live\":true"));
  const auto begin = std::chrono::steady_clock::now();
  view.cancellation.Cancel();
  view.thread.join();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(1));
  EXPECT_TRUE(view.status.ok()) << view.status.message();
}

TEST(ViewCommand, HasATokenWhereTheNetworkCanReachIt) {
  const SyntheticWorkspace workspace;
  RunningView view(
      {workspace.path().string(), "--port", "0", "--host", "0.0.0.0"});
  const std::string text = view.text.Text();
  EXPECT_THAT(
      text.substr(0, text.find('\n')),
      testing::MatchesRegex("view: http://[0-9.]+:[0-9]+/.token=[0-9a-f]+"));
  EXPECT_THAT(text, testing::Not(HasSubstr("//0.0.0.0:")));
}

TEST(ViewCommand, SaysWhatIsWrong) {
  const SyntheticWorkspace workspace;
  const std::string path = workspace.path().string();
  CancellationToken cancellation;
  std::ostringstream out;
  CommandContext context{out, out, cancellation, ""};
  const auto code = [&](const std::vector<std::string>& arguments) {
    return RunViewCommand(arguments, context).code();
  };
  EXPECT_EQ(code({}), StatusCode::kInvalidArgument);
  EXPECT_EQ(code({path, path}), StatusCode::kInvalidArgument);
  EXPECT_EQ(code({path, "--port", "70000"}), StatusCode::kInvalidArgument);
  EXPECT_EQ(code({path + "/missing"}), StatusCode::kBadInput);
  EXPECT_EQ(code({path, "--host", "203.0.113.7"}), StatusCode::kBadInput);
}

}  // namespace
}  // namespace freegs::stages
