// SPDX-License-Identifier: BSD-3-Clause
// The exit codes of the program.

#ifndef FREEGS_PIPELINE_EXIT_CODE_H_
#define FREEGS_PIPELINE_EXIT_CODE_H_

#include "core/status.h"

namespace freegs::pipeline {

// 0 done; 1 a fault of the program or system; 2 wrong usage; 3 bad input; 4 no
// usable result; 5 a missing program or model file; 130 interrupted.
constexpr int ExitCode(StatusCode code) {
  switch (code) {
    case StatusCode::kOk:
      return 0;
    case StatusCode::kInvalidArgument:
      return 2;
    case StatusCode::kBadInput:
      return 3;
    case StatusCode::kUnusableResult:
      return 4;
    case StatusCode::kMissingDependency:
      return 5;
    case StatusCode::kInterrupted:
      return 130;
    case StatusCode::kInternal:
      return 1;
  }
  return 1;
}

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_EXIT_CODE_H_
