// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/evidence.h"

#include <algorithm>
#include <cmath>

namespace freegs::semantics {
namespace {

constexpr double kColorNoise = 2.5e-3;  // Variance, L*a*b* / 100.
// Distances of histograms at which likeness has fallen to 1 / e.
constexpr double kAlike = 0.15;
constexpr double kAlikeAb = 0.05;

// Of the channels from `first` on.
double HistogramDistance(const ColorHistogram& a,
                         double pixels_a,
                         const ColorHistogram& b,
                         double pixels_b,
                         size_t first = 0) {
  if (!(pixels_a > 0) || !(pixels_b > 0)) return 0;
  double sum = 0;
  for (size_t c = first; c < a.size(); ++c) {
    for (size_t k = 0; k < kColorBins; ++k) {
      const double p = a[c][k] / pixels_a;
      const double q = b[c][k] / pixels_b;
      if (p + q > 0) sum += (p - q) * (p - q) / (p + q);
    }
  }
  return sum / 2 / static_cast<double>(a.size() - first);
}

}  // namespace

Evidence MeasureEvidence(const RegionStats& first,
                         const RegionStats& second,
                         const ContactStats& contact,
                         double total_pixels) {
  const bool first_small = first.pixels <= second.pixels;
  const RegionStats& a = first_small ? first : second;
  const RegionStats& b = first_small ? second : first;
  Evidence e = {};
  const double seen = contact.pixels;
  if (seen > 0) {
    e[kContrastNear] = static_cast<float>(contact.contrast_near / seen);
    e[kContrastFar] = static_cast<float>(contact.contrast_far / seen);
    e[kStep] = static_cast<float>(std::min(1.0, 3 * contact.difference / seen));
    e[kDepthStep] = static_cast<float>(contact.depth_step / seen);
  }
  if (seen + contact.hidden > 0) {
    e[kHidden] = static_cast<float>(contact.hidden / (seen + contact.hidden));
    e[kRelief] = static_cast<float>(contact.relief / (seen + contact.hidden));
  }
  if (a.pixels > 0 && b.pixels > 0) {
    const Eigen::Vector3d mean_a = a.color / a.pixels;
    const Eigen::Vector3d mean_b = b.color / b.pixels;
    const double variance_a =
        std::max(0.0, (a.color2 / a.pixels - mean_a.cwiseAbs2()).sum());
    const double variance_b =
        std::max(0.0, (b.color2 / b.pixels - mean_b.cwiseAbs2()).sum());
    const double difference2 = (mean_a - mean_b).squaredNorm();
    e[kColor] = static_cast<float>(std::min(1.0, 2 * std::sqrt(difference2)));
    e[kColorContrast] = static_cast<float>(
        difference2 / (difference2 + variance_a + variance_b + kColorNoise));
    e[kHistogram] = static_cast<float>(
        HistogramDistance(a.histogram, a.pixels, b.histogram, b.pixels));
    e[kLikeness] = std::exp(static_cast<float>(-e[kHistogram] / kAlike));
    e[kLikenessAb] = std::exp(static_cast<float>(
        -HistogramDistance(a.histogram, a.pixels, b.histogram, b.pixels, 1) /
        kAlikeAb));
    e[kContext] = static_cast<float>(HistogramDistance(
        a.context, a.context_pixels, b.context, b.context_pixels));
    e[kSpread] = static_cast<float>(std::min(
        1.0, 4 * std::abs(std::sqrt(variance_a) - std::sqrt(variance_b))));
  }
  if (seen > 0) {
    const double concavity = contact.concavity / seen;
    e[kConcave] = static_cast<float>(std::max(0.0, concavity));
    e[kConvex] = static_cast<float>(std::max(0.0, -concavity));
    e[kBend] = static_cast<float>(contact.bend / seen);
  }
  const double total = std::max(1.0, total_pixels);
  e[kSize] = static_cast<float>(std::log10((a.pixels + 1) / total));
  const double outline = std::max(1.0, std::min(a.perimeter, b.perimeter));
  const double larger_outline =
      std::max(1.0, std::max(a.perimeter, b.perimeter));
  e[kInterleaved] = static_cast<float>(
      std::min(1.0, (seen + contact.hidden) / larger_outline));
  e[kEnclosed] =
      static_cast<float>(std::min(1.0, (seen + contact.hidden) / outline));
  const RegionExtent small = ExtentOf(a.weight, a.position, a.position2);
  const RegionExtent large = ExtentOf(b.weight, b.position, b.position2);
  const RegionExtent both = ExtentOf(
      a.weight + b.weight, a.position + b.position, a.position2 + b.position2);
  e[kFlatSmall] = static_cast<float>(small.Flatness());
  e[kFlatLarge] = static_cast<float>(large.Flatness());
  e[kFlatBoth] = static_cast<float>(both.Flatness());
  const double off = std::abs(large.normal.dot(small.centre - large.centre));
  const double scale = large.thickness + 0.05 * large.width;
  e[kOffPlane] =
      static_cast<float>(scale > 0 ? std::min(1.0, off / scale / 4) : 1);
  if (!a.semantics.empty() && a.semantics.size() == b.semantics.size()) {
    double product = 0;
    double norm_a = 0;
    double norm_b = 0;
    for (size_t k = 0; k < a.semantics.size(); ++k) {
      product += double{a.semantics[k]} * b.semantics[k];
      norm_a += double{a.semantics[k]} * a.semantics[k];
      norm_b += double{b.semantics[k]} * b.semantics[k];
    }
    if (norm_a > 0 && norm_b > 0) {
      e[kSemantics] = static_cast<float>(
          1 - product / (std::sqrt(norm_a) * std::sqrt(norm_b)));
    }
  }
  return e;
}

}  // namespace freegs::semantics
