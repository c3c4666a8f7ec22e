// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/progress_csv.h"

#include <string>

#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

constexpr char kCsvHeader[] =
    "iteration,seconds,loss,num_gaussians,holdout_psnr\n";
constexpr char kCsvRows[] =
    "50,1.500,0.250000,7,\n100,2.000,0.125000,8,20.5000\n";

TEST(ProgressCsvTest, ATrainingThatResumesDropsLaterRows) {
  const TemporaryFolder folder;
  ProgressCsv first(folder / "progress.csv");
  ASSERT_TRUE(first.Open(0).ok());
  EXPECT_EQ(ReadText(folder / "progress.csv"), kCsvHeader);
  first.Add({50, 1.5, 0.25, 7, {}});
  first.Add({100, 2, 0.125, 8, 20.5});
  first.Add({150, 3, 0.1, 9, {}});
  ASSERT_TRUE(first.Flush().ok());

  ProgressCsv second(folder / "progress.csv");
  ASSERT_TRUE(second.Open(120).ok());
  EXPECT_EQ(ReadText(folder / "progress.csv"),
            std::string(kCsvHeader) + kCsvRows);
  // A row of the iteration itself stays.
  ASSERT_TRUE(second.Open(100).ok());
  EXPECT_EQ(ReadText(folder / "progress.csv"),
            std::string(kCsvHeader) + kCsvRows);
  ASSERT_TRUE(second.Open(0).ok());
  EXPECT_EQ(ReadText(folder / "progress.csv"), kCsvHeader);
}

TEST(ProgressCsvTest, LinesThatAreNoRowsAreDropped) {
  const TemporaryFolder folder;
  folder.Write("progress.csv", "no header\n50,1\nwords\n-3,1\n\n60,2");
  ProgressCsv csv(folder / "progress.csv");
  ASSERT_TRUE(csv.Open(100).ok());
  EXPECT_EQ(ReadText(folder / "progress.csv"),
            std::string(kCsvHeader) + "50,1\n60,2\n");
  ProgressCsv none(folder / "none.csv");
  ASSERT_TRUE(none.Open(100).ok());
  EXPECT_EQ(ReadText(folder / "none.csv"), kCsvHeader);
}

}  // namespace
}  // namespace freegs::stages
