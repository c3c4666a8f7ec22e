// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/training_curve.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>

#include "core/number_text.h"
#include "stages/export/html.h"

namespace freegs::stages {
namespace {

// Size of a chart in its own units; the page scales it.
constexpr double kWidth = 360;
constexpr double kHeight = 200;
constexpr double kLeft = 52;
constexpr double kRight = 14;
constexpr double kTop = 34;
constexpr double kBottom = 26;

// More points than the chart has columns are thinned to about this many.
constexpr size_t kMaxPoints = 400;

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

// A step of 1, 2 or 5 times a power of ten that divides `range` into two to
// five parts.
double RoundStep(double range) {
  const double power = std::pow(10.0, std::floor(std::log10(range)));
  for (const double factor : {0.2, 0.5, 1.0, 2.0}) {
    if (range / (factor * power) <= 5.0) return factor * power;
  }
  return 5 * power;
}

// "7k" for 7000, "0.05" for 0.05.
std::string TickLabel(double value) {
  if (std::abs(value) >= 1e6) return FormatFixed(value / 1e6, 1) + "M";
  if (std::abs(value) >= 1000) {
    const double thousands = value / 1000;
    const bool whole = std::abs(thousands - std::round(thousands)) < 0.05;
    return FormatFixed(thousands, whole ? 0 : 1) + "k";
  }
  std::string text = FormatFixed(value, 4);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

std::string Coordinate(double value) { return FormatFixed(value, 1); }

struct Axis {
  double low = 0;
  double high = 1;
  double step = 1;
  double from = 0;  // Where `low` is drawn.
  double to = 1;    // Where `high` is drawn.

  double Place(double value) const {
    return from + (value - low) / (high - low) * (to - from);
  }
};

// An axis from the least to the greatest value, widened when these coincide.
Axis MakeAxis(double low, double high, double from, double to) {
  if (!(high > low)) {
    const double margin = std::max(1e-6, 0.05 * std::abs(high));
    low -= margin;
    high += margin;
  }
  return {low, high, RoundStep(high - low), from, to};
}

std::vector<double> Ticks(const Axis& axis) {
  std::vector<double> ticks;
  const double first = std::ceil(axis.low / axis.step - 1e-9) * axis.step;
  for (int k = 0; k < 8; ++k) {
    const double value = first + k * axis.step;
    if (value > axis.high + 1e-9 * axis.step) break;
    ticks.push_back(std::abs(value) < 1e-9 * axis.step ? 0.0 : value);
  }
  return ticks;
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

std::string LineChartSvg(const std::vector<CurvePoint>& points,
                         const std::string& title,
                         int decimals) {
  if (points.size() < 2) return "";
  const auto by_x = [](const CurvePoint& a, const CurvePoint& b) {
    return a.x < b.x;
  };
  const auto by_y = [](const CurvePoint& a, const CurvePoint& b) {
    return a.y < b.y;
  };
  const auto [low_x, high_x] =
      std::minmax_element(points.begin(), points.end(), by_x);
  const auto [low_y, high_y] =
      std::minmax_element(points.begin(), points.end(), by_y);
  const Axis x = MakeAxis(low_x->x, high_x->x, kLeft, kWidth - kRight);
  const Axis y = MakeAxis(low_y->y, high_y->y, kHeight - kBottom, kTop);

  const CurvePoint& last = points.back();
  const std::string value = decimals == 0 ? FormatCount(std::llround(last.y))
                                          : FormatFixed(last.y, decimals);
  std::string svg =
      "<svg class=\"chart\" viewBox=\"0 0 360 200\" role=\"img\" "
      "aria-label=\"" +
      EscapeHtml(title) + " over iterations, " + value + " at the end\">\n";
  svg += "<text class=\"chart-title\" x=\"0\" y=\"14\">" + EscapeHtml(title) +
         "</text>\n<text class=\"chart-value\" x=\"346\" y=\"14\" "
         "text-anchor=\"end\">" +
         value + "</text>\n";
  for (const double tick : Ticks(y)) {
    const std::string at = Coordinate(y.Place(tick));
    svg += "<line class=\"grid\" x1=\"52\" x2=\"346\" y1=\"" + at + "\" y2=\"" +
           at + "\"/><text class=\"tick\" x=\"46\" y=\"" +
           Coordinate(y.Place(tick) + 3.5) + "\" text-anchor=\"end\">" +
           TickLabel(tick) + "</text>\n";
  }
  for (const double tick : Ticks(x)) {
    svg += "<text class=\"tick\" x=\"" + Coordinate(x.Place(tick)) +
           "\" y=\"194\" text-anchor=\"middle\">" + TickLabel(tick) +
           "</text>\n";
  }
  const size_t stride = points.size() / kMaxPoints + 1;
  std::string path;
  for (size_t i = 0; i < points.size(); ++i) {
    if (i % stride != 0 && i + 1 != points.size()) continue;
    path += (path.empty() ? "M" : "L") + Coordinate(x.Place(points[i].x)) +
            " " + Coordinate(y.Place(points[i].y));
  }
  svg += "<path class=\"curve\" d=\"" + path +
         "\"/>\n<circle class=\"end\" cx=\"" + Coordinate(x.Place(last.x)) +
         "\" cy=\"" + Coordinate(y.Place(last.y)) + "\" r=\"3\"/>\n</svg>\n";
  return svg;
}

}  // namespace freegs::stages
