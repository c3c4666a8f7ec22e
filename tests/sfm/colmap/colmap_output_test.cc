// SPDX-License-Identifier: BSD-3-Clause
// Progress in COLMAP's output, as releases 3.8 and 4.x print it.

#include "sfm/colmap/colmap_output.h"

#include <string>

#include <gtest/gtest.h>

namespace freegs::sfm {
namespace {

using Kind = ColmapProgress::Kind;

TEST(ParseColmapLine, KnownLines) {
  struct Case {
    const char* line;
    Kind kind;
    int done;
    int total;
  };
  const Case cases[] = {
      {"Registering image #7 (12)", Kind::kPhotoRegistered, 12, 0},
      {"Global bundle adjustment", Kind::kAdjusting, 0, 0},
      {"I20260317 10:11:12.1 77 incremental_pipeline.cc:500] Registering image "
       "#7 (num_reg_frames=12)",
       Kind::kPhotoRegistered,
       12,
       0},
      {"Triangulating image #7 (11)", Kind::kPhotoTriangulated, 11, 0},
      {"Undistorting image [2/9]", Kind::kPhotoUndistorted, 2, 9},
  };
  for (const Case& c : cases) {
    const auto progress = ParseColmapLine(c.line);
    ASSERT_TRUE(progress.has_value()) << c.line;
    EXPECT_EQ(progress->kind, c.kind);
    EXPECT_EQ(progress->done, c.done);
    EXPECT_EQ(progress->total, c.total);
  }
}

TEST(ParseColmapLine, EverythingElseIsNothing) {
  for (const char* line : {"",
                           "Elapsed time: 0.1 [minutes]",
                           "Undistorting image [",
                           "Undistorting image [a/b]",
                           "Undistorting image [3",
                           "Undistorting image [99999999999999999999/3]",
                           "Undistorting image [-1/3]",
                           "Registering image #",
                           "Registering image #3",
                           "Triangulating image #3",
                           "Registering image #3 ()"}) {
    EXPECT_FALSE(ParseColmapLine(line)) << line;
  }
}

}  // namespace
}  // namespace freegs::sfm
