// SPDX-License-Identifier: BSD-3-Clause
// The scripts for shells, as the shells run them.

#include "stages/commands/completion_command.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <set>
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

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::IsSupersetOf;
using ::testing::Not;

bool HasShell(const std::string& shell) {
  return std::system((shell + " -c true >/dev/null 2>&1").c_str()) == 0;
}

class CompletionTest : public ::testing::Test {
 protected:
  Status Write(const std::string& shell) {
    std::ostringstream out;
    const CancellationToken never;
    CommandContext context{out, out, never, "", Commands()};
    FREEGS_RETURN_IF_ERROR(RunCompletionCommand({shell}, context));
    WriteText(folder_ / shell, out.str());
    return Status();
  }

  // What bash offers when the cursor is at the end of the last word.
  std::set<std::string> Offers(const std::vector<std::string>& words) {
    std::string list;
    for (const std::string& word : words) list += " '" + word + "'";
    WriteText(folder_ / "ask",
              "cd \"${0%/*}\"\nsource ./bash\nCOMP_WORDS=(freegs_pipeline" +
                  list + ")\nCOMP_CWORD=" + std::to_string(words.size()) +
                  "\n_freegs_pipeline\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n");
    const std::string command =
        "LC_ALL=C bash '" + (folder_ / "ask").string() + "' 2>&1";
    std::string text;
    FILE* const pipe = popen(command.c_str(), "r");
    if (pipe == nullptr) return {"popen fails"};
    std::array<char, 4096> buffer;
    while (const size_t size =
               std::fread(buffer.data(), 1, buffer.size(), pipe)) {
      text.append(buffer.data(), size);
    }
    pclose(pipe);
    std::set<std::string> offers;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      if (!line.empty()) offers.insert(line);
    }
    return offers;
  }

  TemporaryFolder folder_;
};

TEST_F(CompletionTest, BashOffersCommandsOptionsAndFiles) {
  if (!HasShell("bash")) GTEST_SKIP() << "bash is not installed";
  ASSERT_TRUE(Write("bash").ok());
  WriteText(folder_ / "photos 1" / "a.jpg", "");
  WriteText(folder_ / "photos.mp4", "");

  EXPECT_THAT(Offers({"ex"}), ElementsAre("export"));
  EXPECT_THAT(Offers({""}), IsSupersetOf({"run", "query", "--version"}));
  EXPECT_THAT(Offers({"help", "re"}), ElementsAre("render"));

  // Options, and SECTION.KEY.
  EXPECT_THAT(Offers({"run", "--reconstruct.it"}),
              ElementsAre("--reconstruct.iterations"));
  EXPECT_THAT(Offers({"run", "--f"}), ElementsAre("--forget", "--from"));
  EXPECT_THAT(Offers({"query", "--"}),
              AllOf(IsSupersetOf({"--text", "--query.min_relevancy"}),
                    Not(Contains("--sfm.matcher"))));
  EXPECT_THAT(Offers({"init", "w", "--"}), ElementsAre("--help"));

  // Values.
  EXPECT_THAT(Offers({"run", "--preset", ""}),
              ElementsAre("auto", "balanced", "fast", "quality"));
  EXPECT_THAT(Offers({"run", "--preset", "=", "f"}), ElementsAre("fast"));
  EXPECT_THAT(Offers({"run", "--preset", "="}),
              ElementsAre("auto", "balanced", "fast", "quality"));
  EXPECT_THAT(Offers({"run", "--reconstruct.exposure", "o"}),
              ElementsAre("off", "on"));
  EXPECT_THAT(Offers({"run", "--to", "r"}), ElementsAre("reconstruct"));
  EXPECT_THAT(Offers({"stage", "b"}), ElementsAre("bootstrap"));
  EXPECT_THAT(Offers({"run", "--forget", "sfm.mat"}),
              ElementsAre("sfm.matcher"));
  EXPECT_THAT(Offers({"render", "--what", "de"}), ElementsAre("depth"));
  EXPECT_THAT(Offers({"render", "--size", ""}), IsEmpty());
  EXPECT_THAT(Offers({"completion", ""}), ElementsAre("bash", "zsh"));

  // Files and folders, by the number of the argument, which values of options
  // before it do not count for.
  EXPECT_THAT(Offers({"run", "ph"}), ElementsAre("photos 1", "photos.mp4"));
  EXPECT_THAT(Offers({"run", "photos.mp4", "ph"}), ElementsAre("photos 1"));
  EXPECT_THAT(Offers({"run", "--seed", "3", "ph"}),
              ElementsAre("photos 1", "photos.mp4"));
  EXPECT_THAT(Offers({"run", "--verbose", "a", "ph"}), ElementsAre("photos 1"));
  EXPECT_THAT(Offers({"query", "--click", "a", "1", ""}), IsEmpty());
  EXPECT_THAT(Offers({"query", "--click", "a", "1", "2", "ph"}),
              ElementsAre("photos 1"));
  EXPECT_THAT(Offers({"features", "-o", "ph"}),
              ElementsAre("photos 1", "photos.mp4"));
  EXPECT_THAT(Offers({"render", "w", "--out", "ph"}), ElementsAre("photos 1"));
}

TEST_F(CompletionTest, ZshReadsItsScript) {
  if (!HasShell("zsh")) GTEST_SKIP() << "zsh is not installed";
  ASSERT_TRUE(Write("zsh").ok());
  const std::string command = "zsh -n '" + (folder_ / "zsh").string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
}

TEST_F(CompletionTest, OtherShellsHaveNoScript) {
  EXPECT_EQ(Write("fish").code(), StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace freegs::stages
