// SPDX-License-Identifier: BSD-3-Clause

#include "splat/optim/exposure.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <optional>
#include <system_error>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>

#include "core/text.h"
#include "splat/optim/adam.h"

namespace freegs::splat {
namespace {

constexpr int64_t kRowsOfColor = 16;

// What the fit adds to the diagonal of its normal equations for each pixel.
// Numbers that the colours say nothing about stay those of the identity.
constexpr double kFitPull = 1e-5;

// A fit to fewer pixels is the identity.
constexpr int64_t kMinFitPixels = 64;

// Takes a number off the front of *text.
std::optional<uint64_t> TakeNumber(std::string_view* text) {
  uint64_t number = 0;
  const char* const end = text->data() + text->size();
  const auto [rest, error] = std::from_chars(text->data(), end, number);
  if (error != std::errc()) return std::nullopt;
  text->remove_prefix(rest - text->data());
  return number;
}

// How far the number in `name` lies on the way from that in `before`, 0, to
// that in `after`, 1. A half if the names differ in something else.
double ShareBetween(std::string_view before,
                    std::string_view name,
                    std::string_view after) {
  const auto common = [name](std::string_view other) {
    return std::ranges::mismatch(name, other).in1 - name.begin();
  };
  size_t begin = std::min(common(before), common(after));
  while (begin > 0 && IsDigit(name[begin - 1])) --begin;
  for (std::string_view* text : {&before, &name, &after}) {
    text->remove_prefix(begin);
  }
  const std::optional<uint64_t> first = TakeNumber(&before);
  const std::optional<uint64_t> number = TakeNumber(&name);
  const std::optional<uint64_t> last = TakeNumber(&after);
  if (!first || !number || !last || before != name || name != after ||
      *first >= *number || *number >= *last) {
    return 0.5;
  }
  return static_cast<double>(*number - *first) /
         static_cast<double>(*last - *first);
}

}  // namespace

Status ExposureOptions::Check() const {
  if (!(start >= 0 && start < 1)) {
    return InvalidArgumentError("the start of exposure must be in [0, 1)");
  }
  for (const double rate : {rate_initial, rate_final}) {
    if (!(rate > 0 && std::isfinite(rate))) {
      return InvalidArgumentError("the rates of exposure must be > 0");
    }
  }
  if (!(pull >= 0 && std::isfinite(pull))) {
    return InvalidArgumentError("the pull of exposure must be >= 0");
  }
  return Status();
}

AffineColor ExposureBetween(std::span<const PhotoExposure> exposures,
                            std::string_view photo) {
  if (exposures.empty()) return {};
  const auto found = std::ranges::lower_bound(
      exposures, photo, NaturalLess, [](const PhotoExposure& exposure) {
        return std::string_view(exposure.photo);
      });
  const bool itself = found != exposures.end() && found->photo == photo;
  const auto after = itself ? found + 1 : found;
  const bool is_first = found == exposures.begin();
  const bool is_last = after == exposures.end();
  if (is_first && is_last) return {};
  if (is_first) return after->color;
  const PhotoExposure& before = *(found - 1);
  if (is_last) return before.color;
  const auto share =
      static_cast<float>(ShareBetween(before.photo, photo, after->photo));
  AffineColor between;
  for (size_t k = 0; k < between.values.size(); ++k) {
    between.values[k] =
        (1 - share) * before.color.values[k] + share * after->color.values[k];
  }
  return between;
}

double ExposureRate(const ExposureOptions& options, double share) {
  const double t = (share - options.start) / (1 - options.start);
  return std::exp((1 - t) * std::log(options.rate_initial) +
                  t * std::log(options.rate_final));
}

void ApplyColor(const AffineColor& color,
                const ImageF& scene,
                ThreadPool& pool,
                ImageF* photo) {
  const std::array<float, 12>& m = color.values;
  photo->Reshape(scene.width(), scene.height(), 3);
  pool.ParallelFor(
      0, scene.height(), kRowsOfColor, [&](int64_t begin, int64_t end, int) {
        const float* in = scene.row(static_cast<int>(begin));
        const float* const last = scene.row(static_cast<int>(end));
        float* out = photo->row(static_cast<int>(begin));
        for (; in != last; in += 3, out += 3) {
          const float r = in[0], g = in[1], b = in[2];
          for (int k = 0; k < 3; ++k) {
            const float* const row = &m[4 * k];
            out[k] = row[0] * r + row[1] * g + row[2] * b + row[3];
          }
        }
      });
}

AffineColor Inverse(const AffineColor& color) {
  using Matrix = Eigen::Matrix<float, 3, 4, Eigen::RowMajor>;
  const Eigen::Map<const Matrix> matrix(color.values.data());
  const Eigen::Matrix3f inverse = matrix.leftCols<3>().inverse();
  if (!inverse.allFinite()) return {};
  AffineColor result;
  Eigen::Map<Matrix>(result.values.data()) << inverse, -inverse * matrix.col(3);
  return result;
}

AffineColor BackwardColor(const AffineColor& color,
                          const ImageF& scene,
                          ThreadPool& pool,
                          std::vector<ColorSums>* scratch,
                          ImageF* gradient) {
  const std::array<float, 12>& m = color.values;
  std::vector<ColorSums>& sums = *scratch;
  sums.assign((scene.height() + kRowsOfColor - 1) / kRowsOfColor, ColorSums());
  pool.ParallelFor(
      0, scene.height(), kRowsOfColor, [&](int64_t begin, int64_t end, int) {
        ColorSums& sum = sums[begin / kRowsOfColor];
        for (int64_t y = begin; y < end; ++y) {
          const float* in = scene.row(static_cast<int>(y));
          float* d = gradient->row(static_cast<int>(y));
          std::array<float, 12> row_sum = {};
          for (int x = 0; x < scene.width(); ++x, in += 3, d += 3) {
            const float dr = d[0], dg = d[1], db = d[2];
            for (int k = 0; k < 3; ++k) {
              for (int c = 0; c < 3; ++c) row_sum[4 * k + c] += d[k] * in[c];
              row_sum[4 * k + 3] += d[k];
            }
            for (int c = 0; c < 3; ++c) {
              d[c] = m[c] * dr + m[4 + c] * dg + m[8 + c] * db;
            }
          }
          for (int i = 0; i < 12; ++i) sum[i] += row_sum[i];
        }
      });
  AffineColor result;
  for (int i = 0; i < 12; ++i) {
    double total = 0;
    for (const ColorSums& sum : sums) total += sum[i];
    result.values[i] = static_cast<float>(total);
  }
  return result;
}

void PhotoColors::Step(size_t photo,
                       const AffineColor& gradient,
                       double rate,
                       double pull) {
  Entry& entry = entries[photo];
  const AdamOptions options;
  const AdamCoefficients adam = CoefficientsAt(options, ++entry.steps, rate);
  const auto count = static_cast<float>(entries.size());
  const auto back = static_cast<float>(rate * pull);
  const AffineColor identity;
  for (int i = 0; i < 12; ++i) {
    const float d = gradient.values[i];
    float& first = entry.first_moment[i];
    float& second = entry.second_moment[i];
    first += adam.one_minus_beta1 * (d - first);
    second = adam.beta2 * second + adam.one_minus_beta2 * d * d;
    const float change =
        -adam.step_size * first /
            (std::sqrt(second) * adam.root_correction + adam.epsilon) -
        back * (entry.color.values[i] - identity.values[i]);
    if (!std::isfinite(change)) continue;
    entry.color.values[i] += change;
    // The mean over all photographs stays where it was.
    for (Entry& other : entries) other.color.values[i] -= change / count;
  }
}

AffineColor FitColor(const ImageF& scene,
                     const ImageF& photo,
                     const ImageU8* mask,
                     int begin,
                     int end) {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, 3> right = Eigen::Matrix<double, 4, 3>::Zero();
  int64_t count = 0;
  for (int y = 0; y < scene.height(); ++y) {
    for (int x = begin; x < end; ++x) {
      if (mask != nullptr && (*mask)(x, y) == 0) continue;
      const Eigen::Vector4d in(
          scene(x, y, 0), scene(x, y, 1), scene(x, y, 2), 1);
      const Eigen::RowVector3d out(
          photo(x, y, 0), photo(x, y, 1), photo(x, y, 2));
      normal += in * in.transpose();
      right += in * out;
      ++count;
    }
  }
  if (count < kMinFitPixels) return {};
  Eigen::Matrix<double, 4, 3> identity = Eigen::Matrix<double, 4, 3>::Zero();
  identity.topRows<3>().setIdentity();
  const double pull = kFitPull * static_cast<double>(count);
  normal.diagonal().array() += pull;
  right += pull * identity;
  const Eigen::Matrix<double, 4, 3> fit = normal.ldlt().solve(right);
  if (!fit.allFinite()) return {};
  AffineColor color;
  for (int k = 0; k < 3; ++k) {
    for (int c = 0; c < 4; ++c) {
      color.values[4 * k + c] = static_cast<float>(fit(c, k));
    }
  }
  return color;
}

}  // namespace freegs::splat
