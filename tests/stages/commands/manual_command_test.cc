// SPDX-License-Identifier: BSD-3-Clause
// The pages of the manual, as programs that read man pages and as docs/ have
// them.

#include "stages/commands/manual_command.h"

#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/cancellation.h"
#include "stages/commands/command_list.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

StatusOr<std::string> Manual(const std::vector<std::string>& arguments) {
  std::ostringstream out;
  const CancellationToken never;
  CommandContext context{out, out, never, "", Commands()};
  FREEGS_RETURN_IF_ERROR(RunManualCommand(arguments, context));
  return out.str();
}

bool HasProgram(const std::string& name) {
  return std::system(("command -v " + name + " >/dev/null 2>&1").c_str()) == 0;
}

TEST(ManualCommandTest, PageOfOptionsInTheSourcesIsWhatItPrints) {
  const StatusOr<std::string> page = Manual({"options"});
  ASSERT_TRUE(page.ok()) << page.status().message();
  EXPECT_TRUE(ReadText(fs::path(FREEGS_SOURCE_DIR) / "docs/options.md") ==
              *page)
      << "after a change of options: freegs_pipeline manual options > "
         "docs/options.md";
}

TEST(ManualCommandTest, ManPageNamesAllCommandsAndIsAlwaysTheSame) {
  const StatusOr<std::string> page = Manual({"man"});
  ASSERT_TRUE(page.ok()) << page.status().message();
  for (const Command& command : Commands()) {
    EXPECT_THAT(*page, HasSubstr(".SS \"" + std::string(command.name)));
  }
  EXPECT_EQ(*Manual({"man"}), *page);
  EXPECT_EQ(page->find("\n\n"), std::string::npos) << "an empty line";
}

// Runs a checker, which prints what it finds wrong, on the page.
std::string Complaints(const std::string& checker) {
  const TemporaryFolder folder;
  const StatusOr<std::string> page = Manual({"man"});
  if (!page.ok()) return page.status().message();
  WriteText(folder / "page.1", *page);
  const std::string command = checker + " '" + (folder / "page.1").string() +
                              "' >'" + (folder / "said").string() + "' 2>&1";
  const int result = std::system(command.c_str());
  const std::string said = ReadText(folder / "said");
  return said.empty() && result != 0 ? "exit status " + std::to_string(result)
                                     : said;
}

TEST(ManualCommandTest, GroffSetsThePageWithoutWarnings) {
  if (!HasProgram("groff")) GTEST_SKIP() << "groff is not installed";
  EXPECT_EQ(Complaints("groff -man -Tutf8 -ww -z"), "");
}

TEST(ManualCommandTest, MandocOnlyMissesTheDate) {
  if (!HasProgram("mandoc")) GTEST_SKIP() << "mandoc is not installed";
  std::istringstream lines(Complaints("mandoc -T lint"));
  for (std::string line; std::getline(lines, line);) {
    EXPECT_THAT(line, HasSubstr("missing date"));
  }
}

TEST(ManualCommandTest, OtherPagesAreWrongUsage) {
  EXPECT_EQ(Manual({"html"}).status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(Manual({}).status().code(), StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace freegs::stages
