// SPDX-License-Identifier: BSD-3-Clause
// The course of the training as small line charts.

#ifndef FREEGS_STAGES_EXPORT_TRAINING_CURVE_H_
#define FREEGS_STAGES_EXPORT_TRAINING_CURVE_H_

#include <string>
#include <string_view>
#include <vector>

namespace freegs::stages {

struct CurvePoint {
  double x = 0;
  double y = 0;
};

// What reconstruct/progress.csv says, by iteration.
struct TrainingCurves {
  std::vector<CurvePoint> loss;
  std::vector<CurvePoint> num_gaussians;
  std::vector<CurvePoint> holdout_psnr;  // Fewer points: measured now and then.
};

// Reads the columns by their names in the first line, in any order. Rows and
// fields that are no finite numbers are left out; so is a column that is not
// there. Never fails.
TrainingCurves ParseTrainingCurves(std::string_view csv);

// An <svg> element of one line over iterations: three round numbers on either
// axis, the last value written at its end, colours from the page's CSS
// variables. Empty for fewer than two points.
// title: what y is; decimals: of the last value.
std::string LineChartSvg(const std::vector<CurvePoint>& points,
                         const std::string& title,
                         int decimals);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_TRAINING_CURVE_H_
