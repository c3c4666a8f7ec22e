// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/local_relief.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace freegs::semantics {
namespace {

// So many pixels of a window must be known.
constexpr double kMinPixels = 6;
// Pixels beside the boundary blend both sides and are left out.
constexpr int kGap = 1;
// Added to the variance of pixels' places, so that slopes of narrow windows are
// moderate. What is seen at a grazing angle keeps a small step by this.
constexpr double kRidge = 0.1;
// Differences of depth that say nothing, as a share of it.
constexpr double kDepthNoise = 0.01;

// Inverse depth near a window: value at a place, slopes, variance around it.
struct Fit {
  double x = 0;
  double y = 0;
  double value = 0;
  double slope_x = 0;
  double slope_y = 0;
  double variance = 0;

  double At(double u, double v) const {
    return value + slope_x * (u - x) + slope_y * (v - y);
  }
};

std::optional<Fit> FitPlane(const std::array<double, 10>& sums) {
  const double n = sums[0];
  if (n < kMinPixels) return std::nullopt;
  Fit fit;
  fit.x = sums[1] / n;
  fit.y = sums[2] / n;
  fit.value = sums[3] / n;
  const double xx = std::max(0.0, sums[4] / n - fit.x * fit.x) + kRidge;
  const double xy = sums[5] / n - fit.x * fit.y;
  const double yy = std::max(0.0, sums[6] / n - fit.y * fit.y) + kRidge;
  const double xd = sums[7] / n - fit.x * fit.value;
  const double yd = sums[8] / n - fit.y * fit.value;
  const double dd = std::max(0.0, sums[9] / n - fit.value * fit.value);
  const double determinant = xx * yy - xy * xy;
  if (!(determinant > 0)) return std::nullopt;
  fit.slope_x = (xd * yy - yd * xy) / determinant;
  fit.slope_y = (yd * xx - xd * xy) / determinant;
  fit.variance = std::max(0.0, dd - fit.slope_x * xd - fit.slope_y * yd);
  return fit;
}

}  // namespace

LocalRelief::LocalRelief(const ImageF& inverse_depth, double noise)
    : table_(inverse_depth.width(),
             inverse_depth.height(),
             [&inverse_depth](int x, int y) {
               const double d = inverse_depth(x, y);
               if (!(d > 0)) return SumTable<kSums>::Sums{};
               const double u = x;
               const double v = y;
               return SumTable<kSums>::Sums{
                   1, u, v, d, u * u, u * v, v * v, u * d, v * d, d * d};
             }),
      noise_(noise) {}

double LocalRelief::Step(int x, int y, bool horizontal, int reach) const {
  const int half = (reach + 1) / 2;
  const int edge = (horizontal ? x : y) + 1;
  const auto window = [&](int begin, int end) {
    SumTable<kSums>::Sums sums;
    if (horizontal) {
      table_.Sum(begin, y - half, end, y + half + 1, &sums);
    } else {
      table_.Sum(x - half, begin, x + half + 1, end, &sums);
    }
    return FitPlane(sums);
  };
  const auto a = window(edge - kGap - reach, edge - kGap);
  const auto b = window(edge + kGap, edge + kGap + reach);
  if (!a || !b) return 0;
  const double u = horizontal ? edge - 0.5 : x;
  const double v = horizontal ? y : edge - 0.5;
  const double step = a->At(u, v) - b->At(u, v);
  const double share = 0.5 * kDepthNoise * (a->value + b->value);
  return step * step /
         (step * step + a->variance + b->variance + noise_ * noise_ +
          share * share);
}

}  // namespace freegs::semantics
