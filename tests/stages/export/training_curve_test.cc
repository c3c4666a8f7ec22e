// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/training_curve.h"

#include <algorithm>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace freegs::stages {
namespace {

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

TEST(TrainingCurveTest, JsonHasColumnsOfOneLength) {
  const TrainingCurves curves = ParseTrainingCurves(
      "loss,iteration,holdout_psnr,num_gaussians\n"
      "0.5,50,,100\n0.25,100,21.5,200\n");
  EXPECT_EQ(TrainingCurvesJson(curves),
            nlohmann::json::parse(R"({"iteration": [50, 100],
              "loss": [0.5, 0.25], "holdout_psnr": [null, 21.5],
              "num_gaussians": [100, 200]})"));
  EXPECT_EQ(TrainingCurvesJson({})["iteration"].size(), 0u);
}

TEST(TrainingCurveTest, JsonOfALongCourseKeepsWhatIsRare) {
  TrainingCurves curves;
  for (int i = 0; i <= 50000; ++i) curves.loss.push_back({1.0 * i, 1});
  curves.holdout_psnr = {{12345, 20}, {50000, 30}};
  const nlohmann::json json = TrainingCurvesJson(curves);
  EXPECT_LT(json["loss"].size(), 900u);
  EXPECT_EQ(json["iteration"].back(), 50000);
  EXPECT_EQ(json["holdout_psnr"].back(), 30);
  EXPECT_NE(
      std::find(json["iteration"].begin(), json["iteration"].end(), 12345),
      json["iteration"].end());
}

}  // namespace
}  // namespace freegs::stages
