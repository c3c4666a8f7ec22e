// SPDX-License-Identifier: BSD-3-Clause
// Durations as people write them on a command line.

#ifndef FREEGS_STAGES_RUN_DURATION_H_
#define FREEGS_STAGES_RUN_DURATION_H_

#include <string_view>

#include "core/status.h"

namespace freegs::stages {

// The seconds of "90s", "5m", "1h", "1h30m" or, without a unit, "90". Each unit
// once, in this order; numbers may have a point. kInvalidArgument for other
// texts, for zero and for more than a year.
StatusOr<double> ParseDuration(std::string_view text);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RUN_DURATION_H_
