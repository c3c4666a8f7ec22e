// SPDX-License-Identifier: BSD-3-Clause
// The course of the training, for the charts of the page.

#ifndef FREEGS_STAGES_EXPORT_TRAINING_CURVE_H_
#define FREEGS_STAGES_EXPORT_TRAINING_CURVE_H_

#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

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

// {"iteration": [...], "loss": [...], "holdout_psnr": [...],
//  "num_gaussians": [...]}, all of one length, null where a row has no such
// number. Long courses are thinned.
nlohmann::json TrainingCurvesJson(const TrainingCurves& curves);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_TRAINING_CURVE_H_
