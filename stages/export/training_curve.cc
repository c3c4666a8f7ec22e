// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/training_curve.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <optional>

#include <nlohmann/json.hpp>

namespace freegs::stages {
namespace {

// Longer courses are thinned to about so many rows.
constexpr size_t kMaxRows = 800;

std::vector<std::string_view> Split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

std::optional<double> Number(std::string_view text) {
  const std::string copy(text);
  char* end = nullptr;
  const double value = std::strtod(copy.c_str(), &end);
  if (end == copy.c_str() || !std::isfinite(value)) return std::nullopt;
  while (*end == ' ' || *end == '\r') ++end;
  if (*end != '\0') return std::nullopt;
  return value;
}

}  // namespace

TrainingCurves ParseTrainingCurves(std::string_view csv) {
  TrainingCurves curves;
  const std::vector<std::string_view> lines = Split(csv, '\n');
  std::vector<std::string_view> header = Split(lines[0], ',');
  if (header.back().ends_with('\r')) header.back().remove_suffix(1);
  const auto column = [&header](std::string_view name) -> size_t {
    return static_cast<size_t>(std::find(header.begin(), header.end(), name) -
                               header.begin());
  };
  const size_t iteration_column = column("iteration");
  const std::pair<size_t, std::vector<CurvePoint>*> targets[] = {
      {column("loss"), &curves.loss},
      {column("num_gaussians"), &curves.num_gaussians},
      {column("holdout_psnr"), &curves.holdout_psnr}};
  for (size_t row = 1; row < lines.size(); ++row) {
    const std::vector<std::string_view> fields = Split(lines[row], ',');
    if (iteration_column >= fields.size()) continue;
    const std::optional<double> iteration = Number(fields[iteration_column]);
    if (!iteration) continue;
    for (const auto& [index, points] : targets) {
      if (index >= fields.size()) continue;
      const std::optional<double> value = Number(fields[index]);
      if (value) points->push_back({*iteration, *value});
    }
  }
  return curves;
}

nlohmann::json TrainingCurvesJson(const TrainingCurves& curves) {
  std::map<double, std::array<std::optional<double>, 3>> rows;
  const std::vector<CurvePoint>* columns[] = {
      &curves.loss, &curves.holdout_psnr, &curves.num_gaussians};
  for (size_t c = 0; c < 3; ++c) {
    for (const CurvePoint& point : *columns[c]) rows[point.x][c] = point.y;
  }
  nlohmann::json json = {{"iteration", nlohmann::json::array()},
                         {"loss", nlohmann::json::array()},
                         {"holdout_psnr", nlohmann::json::array()},
                         {"num_gaussians", nlohmann::json::array()}};
  const size_t step = 1 + rows.size() / kMaxRows;
  size_t at = 0;
  for (const auto& [iteration, values] : rows) {
    // PSNR is measured in few rows, and the last row is the result.
    if (at++ % step != 0 && !values[1] && at != rows.size()) continue;
    json["iteration"].push_back(iteration);
    const char* names[] = {"loss", "holdout_psnr", "num_gaussians"};
    for (size_t c = 0; c < 3; ++c) {
      json[names[c]].push_back(values[c] ? nlohmann::json(*values[c])
                                         : nlohmann::json());
    }
  }
  return json;
}

}  // namespace freegs::stages
