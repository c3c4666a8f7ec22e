// SPDX-License-Identifier: BSD-3-Clause
// The times of an answer's parts.

#ifndef FREEGS_STAGES_QUERY_LAP_H_
#define FREEGS_STAGES_QUERY_LAP_H_

#include <chrono>
#include <utility>

namespace freegs::stages {

// Measures the milliseconds since its last call.
class Lap {
 public:
  double Milliseconds() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double, std::milli>(now -
                                                     std::exchange(start_, now))
        .count();
  }

 private:
  std::chrono::steady_clock::time_point start_ =
      std::chrono::steady_clock::now();
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_QUERY_LAP_H_
