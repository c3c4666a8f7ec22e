// SPDX-License-Identifier: BSD-3-Clause
// Draws the course of the training as small line charts.

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

// The columns of reconstruct/progress.csv; x is the iteration.
struct TrainingCurves {
  std::vector<CurvePoint> loss;
  std::vector<CurvePoint> num_gaussians;
  std::vector<CurvePoint> holdout_psnr;  // dB; not measured in every row.
};

// Reads the columns by the names in the first line, in any order. Fields that
// are not finite numbers are left out, and a column that is missing stays
// empty.
TrainingCurves ParseTrainingCurves(std::string_view csv);

// Returns an <svg> element with one line over iterations. Each axis has three
// round numbers, the last value is written at the end of the line with so many
// `decimals`, and colours come from the page's CSS variables. `title` says what
// y is. The text is empty for fewer than two points.
std::string LineChartSvg(const std::vector<CurvePoint>& points,
                         const std::string& title,
                         int decimals);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_TRAINING_CURVE_H_
