// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/forecast/stage_need.h"

#include <algorithm>

#include "core/number_text.h"

namespace freegs::pipeline {

std::string MemoryText(const StageNeed& need, int64_t available_bytes) {
  const bool enough = need.memory_bytes <= available_bytes;
  std::string text =
      "needs about " + FormatBytes(static_cast<double>(need.memory_bytes)) +
      " of memory, " + (enough ? "" : "but only ") +
      FormatBytes(static_cast<double>(available_bytes)) + " are available";
  if (!enough) {
    text += "; the system may end it or become very slow";
    if (!need.advice.empty()) text += ". To need less, " + need.advice;
  }
  return text;
}

double OnThreads(double seconds, double serial, int threads) {
  return seconds * (serial + (1 - serial) / std::max(threads, 1));
}

RunNeed Total(std::span<const StageForecast> stages) {
  RunNeed total;
  for (const auto& [stage, needed, reason, need, begun] : stages) {
    if (!needed) continue;
    if (!need.known()) total.unknown.push_back(stage);
    total.sum.seconds += need.seconds;
    total.sum.disk_bytes += need.disk_bytes;
    total.sum.memory_bytes =
        std::max(total.sum.memory_bytes, need.memory_bytes);
  }
  return total;
}

std::string RunNeedText(const RunNeed& need) {
  std::string text;
  if (need.sum.known()) {
    text = "expected to take about " + FormatSeconds(need.sum.seconds) + ", " +
           FormatBytes(static_cast<double>(need.sum.memory_bytes)) +
           " of memory and " +
           FormatBytes(static_cast<double>(need.sum.disk_bytes)) +
           " of disk space";
  }
  for (size_t i = 0; i < need.unknown.size(); ++i) {
    text += i > 0          ? ", "
            : text.empty() ? "nothing is known of "
                           : "; nothing is known of ";
    text += need.unknown[i];
  }
  return text;
}

}  // namespace freegs::pipeline
