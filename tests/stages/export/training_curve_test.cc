// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/training_curve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(TrainingCurveTest, ReadsColumnsByName) {
  const TrainingCurves curves = ParseTrainingCurves(
      "loss,iteration,holdout_psnr,num_gaussians\r\n"
      "0.5,50,,100\r\n0.25,100,21.5,200\r\n");
  ASSERT_EQ(curves.loss.size(), 2u);
  EXPECT_EQ(curves.loss[1].x, 100);
  EXPECT_EQ(curves.loss[1].y, 0.25);
  ASSERT_EQ(curves.num_gaussians.size(), 2u);
  EXPECT_EQ(curves.num_gaussians[1].y, 200);
  ASSERT_EQ(curves.holdout_psnr.size(), 1u);
  EXPECT_EQ(curves.holdout_psnr[0].y, 21.5);
}

TEST(TrainingCurveTest, SkipsWhatIsNoNumber) {
  const TrainingCurves curves = ParseTrainingCurves(
      "iteration,loss\nx,1\n1\n2,nan\n3,inf\n4,1e999\n"
      "5,2,3,4\n6,1z\n,\n");
  ASSERT_EQ(curves.loss.size(), 1u);
  EXPECT_EQ(curves.loss[0].x, 5);
  for (const char* text :
       {"", "\n", ",,,\n,,,", "loss\n1\n2", "iteration\n1"}) {
    EXPECT_TRUE(ParseTrainingCurves(text).loss.empty());
  }
}

TEST(TrainingCurveTest, DrawsWithinTheChart) {
  std::vector<CurvePoint> points;
  for (int i = 0; i <= 5000; ++i) points.push_back({1.0 * i, 1.0 / (1 + i)});
  const std::string svg = LineChartSvg(points, "Loss & more", 4);
  EXPECT_THAT(svg, HasSubstr("Loss &amp; more"));
  EXPECT_THAT(svg, HasSubstr("0.0002</text>"));
  EXPECT_THAT(svg, HasSubstr("d=\"M52.0 34.0L"));
  EXPECT_THAT(svg, HasSubstr("cx=\"346.0\" cy=\"174.0\""));
  EXPECT_LT(svg.size(), 12000u);
}

TEST(TrainingCurveTest, DegenerateCurves) {
  EXPECT_EQ(LineChartSvg({}, "a", 1), "");
  EXPECT_EQ(LineChartSvg({{1, 1}}, "a", 1), "");
  for (const auto& points : {std::vector<CurvePoint>{{1, 1}, {2, 1}},
                             {{1, 0}, {1, 0}},
                             {{-1e308, -1e308}, {1e308, 1e308}},
                             {{0, 1e-320}, {1, 2e-320}}}) {
    const std::string svg = LineChartSvg(points, "a", 1);
    EXPECT_THAT(svg, HasSubstr("</svg>"));
    EXPECT_THAT(svg, Not(HasSubstr("nan")));
    EXPECT_THAT(svg, Not(HasSubstr("inf")));
  }
}

}  // namespace
}  // namespace freegs::stages
