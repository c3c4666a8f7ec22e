// SPDX-License-Identifier: BSD-3-Clause
// The options of stage undistort: names, help texts and ranges.

#include "pipeline/option_table.h"
#include "stages/sfm/undistort_stage.h"

namespace freegs::stages {

void RegisterUndistortOptions(UndistortStageOptions& options,
                              pipeline::OptionTable& table) {
  table.AddSection("undistort", "Photos and cameras without lens distortion.");
  table.Add("undistort.max_image_size",
            &options.max_image_size,
            {.help = "Longest side in pixels of the written photos; 0 keeps "
                     "their own.",
             .min = 0,
             .max = 100000});
}

}  // namespace freegs::stages
