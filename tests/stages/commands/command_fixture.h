// SPDX-License-Identifier: BSD-3-Clause
// Commands in an empty folder.

#ifndef FREEGS_TESTS_STAGES_COMMANDS_COMMAND_FIXTURE_H_
#define FREEGS_TESTS_STAGES_COMMANDS_COMMAND_FIXTURE_H_

#include <cstdint>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/cancellation.h"
#include "core/image.h"
#include "core/io/image_io.h"
#include "core/status.h"
#include "stages/commands/command.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {

class CommandFixture : public ::testing::Test {
 protected:
  Status Call(CommandFn command, const std::vector<std::string>& arguments) {
    std::ostringstream out;
    std::ostringstream err;
    CommandContext context{out, err, cancellation_, "freegs_pipeline"};
    const Status status = command(arguments, context);
    out_ = out.str();
    return status;
  }

  void ExpectError(CommandFn command,
                   const std::vector<std::string>& arguments,
                   StatusCode code,
                   const std::string& part) {
    const Status status = Call(command, arguments);
    EXPECT_EQ(status.code(), code) << status.message();
    EXPECT_THAT(status.message(), ::testing::HasSubstr(part));
  }

  std::string Path(const std::string& name) const {
    return (folder_ / name).string();
  }

  // Three photos that differ.
  void WritePhotos() const {
    std::filesystem::create_directories(folder_ / "photos");
    for (const int k : {1, 2, 3}) {
      ASSERT_TRUE(WriteImage(folder_ / "photos" / (std::to_string(k) + ".png"),
                             ImageU8(64, 48, 3, static_cast<uint8_t>(50 * k)))
                      .ok());
    }
  }

  TemporaryFolder folder_;
  CancellationToken cancellation_;
  std::string out_;
};

}  // namespace freegs::stages

#endif  // FREEGS_TESTS_STAGES_COMMANDS_COMMAND_FIXTURE_H_
