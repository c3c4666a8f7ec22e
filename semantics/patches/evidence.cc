// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace freegs::semantics {
namespace {

constexpr double kColorNoise = 2.5e-3;  // Variance, L*a*b* / 100.
// Distances of histograms at which likeness has fallen to 1 / e.
constexpr double kAlike = 0.15;
constexpr double kAlikeAb = 0.05;

// Returns half the chi-squared distance of the two histograms, from 0 to 1, for
// each channel.
Eigen::Array3d HistogramDistances(const ColorHistogram& a,
                                  double pixels_a,
                                  const ColorHistogram& b,
                                  double pixels_b) {
  Eigen::Array3d distances = Eigen::Array3d::Zero();
  if (!(pixels_a > 0) || !(pixels_b > 0)) return distances;
  // Keeps empty bins from dividing by 0.
  constexpr double kTiny = 1e-300;
  const double scale_a = 1 / pixels_a;
  const double scale_b = 1 / pixels_b;
  for (size_t c = 0; c < a.size(); ++c) {
    std::array<double, kColorBins> terms;
    for (size_t k = 0; k < kColorBins; ++k) {
      const double p = a[c][k] * scale_a;
      const double q = b[c][k] * scale_b;
      terms[k] = (p - q) * (p - q) / (p + q + kTiny);
    }
    distances[static_cast<Eigen::Index>(c)] =
        std::accumulate(terms.begin(), terms.end(), 0.0) / 2;
  }
  return distances;
}

}  // namespace

Evidence MeasureEvidence(const MeasuredRegion& first,
                         const MeasuredRegion& second,
                         const ContactStats& contact,
                         double total_pixels) {
  const bool first_small = first.stats.pixels <= second.stats.pixels;
  const auto& [a, small] = first_small ? first : second;
  const auto& [b, large] = first_small ? second : first;
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
    const Eigen::Array3d own =
        HistogramDistances(a.histogram, a.pixels, b.histogram, b.pixels);
    e[kHistogram] = static_cast<float>(own.mean());
    e[kLikeness] = std::exp(static_cast<float>(-e[kHistogram] / kAlike));
    e[kLikenessAb] =
        std::exp(static_cast<float>(-(own[1] + own[2]) / 2 / kAlikeAb));
    e[kContext] = static_cast<float>(
        HistogramDistances(
            a.context, a.context_pixels, b.context, b.context_pixels)
            .mean());
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
  e[kFlatSmall] = static_cast<float>(small.Flatness());
  e[kFlatLarge] = static_cast<float>(large.Flatness());
  e[kFlatBoth] = static_cast<float>(FlatnessOf(
      a.weight + b.weight, a.position + b.position, a.position2 + b.position2));
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

std::vector<Evidence> EvidenceOfContacts(const RegionGraph& graph) {
  std::vector<RegionExtent> extents;
  for (const RegionStats& region : graph.regions) {
    extents.push_back(ExtentOf(region));
  }
  std::vector<Evidence> evidence;
  for (const auto& [a, b, stats] : graph.contacts) {
    evidence.push_back(MeasureEvidence({graph.regions[a], extents[a]},
                                       {graph.regions[b], extents[b]},
                                       stats,
                                       graph.total_pixels));
  }
  return evidence;
}

}  // namespace freegs::semantics
