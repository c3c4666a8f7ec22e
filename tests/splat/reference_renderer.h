// SPDX-License-Identifier: BSD-3-Clause
// The renderer as its definition reads: every pixel, every Gaussian, in double.
// No tiles, no SIMD, no shortcuts; what the fast one is compared against.

#ifndef FREEGS_TESTS_SPLAT_REFERENCE_RENDERER_H_
#define FREEGS_TESTS_SPLAT_REFERENCE_RENDERER_H_

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/pinhole.h"
#include "splat/projection/ewa_projection-inl.h"
#include "splat/projection/projection.h"
#include "splat/projection/spherical_harmonics-inl.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

using HWY_NAMESPACE::EvaluateShBasis;
using HWY_NAMESPACE::LogOpacityFilter;
using HWY_NAMESPACE::ProjectGaussian;

// A model in double.
struct ReferenceModel {
  int sh_degree = 0;
  std::vector<double> means, log_scales, rotations, opacity_logits, sh_dc,
      sh_rest, features;
  int num_features = 0;
  bool antialiased = false;

  explicit ReferenceModel(const GaussianModel& model)
      : sh_degree(model.sh_degree),
        means(model.means.begin(), model.means.end()),
        log_scales(model.log_scales.begin(), model.log_scales.end()),
        rotations(model.rotations.begin(), model.rotations.end()),
        opacity_logits(model.opacity_logits.begin(),
                       model.opacity_logits.end()),
        sh_dc(model.sh_dc.begin(), model.sh_dc.end()),
        sh_rest(model.sh_rest.begin(), model.sh_rest.end()),
        antialiased(model.antialiased) {}

  size_t size() const { return opacity_logits.size(); }
};

// H x W pixels of 3 colours (background blended in), transmittance, depth, then
// the features: 5 + num_features doubles each.
inline std::vector<double> ReferenceRender(const ReferenceModel& model,
                                           const Pinhole& pinhole,
                                           const Rigid3d& cam_from_world,
                                           const RenderOptions& options) {
  const auto camera =
      MakeProjectionCamera<double>(pinhole, cam_from_world, options);
  struct Item {
    ProjectedGaussian<double> projected;
    double opacity;
    double color[3];
    size_t index;
  };
  std::vector<Item> items;
  for (size_t i = 0; i < model.size(); ++i) {
    Item item;
    item.index = i;
    ProjectionTerms<double> terms;
    if (!ProjectGaussian(camera,
                         &model.means[3 * i],
                         &model.log_scales[3 * i],
                         &model.rotations[4 * i],
                         &item.projected,
                         &terms)) {
      continue;
    }
    item.opacity = 1 / (1 + std::exp(-model.opacity_logits[i]));
    if (model.antialiased) {
      item.opacity *= std::exp(LogOpacityFilter(terms));
    }
    double direction[3];
    double norm = 0;
    for (int k = 0; k < 3; ++k) {
      direction[k] = model.means[3 * i + k] - camera.centre[k];
      norm += direction[k] * direction[k];
    }
    for (double& v : direction) v /= std::sqrt(norm);
    double basis[15];
    EvaluateShBasis(
        model.sh_degree, direction[0], direction[1], direction[2], basis);
    const int rest = NumShCoefficients(model.sh_degree) - 1;
    for (int c = 0; c < 3; ++c) {
      double value = 0.5 + kShC0 * model.sh_dc[3 * i + c];
      for (int k = 0; k < rest; ++k) {
        value += basis[k] * model.sh_rest[(i * rest + k) * 3 + c];
      }
      item.color[c] = std::max(0.0, value);
    }
    items.push_back(item);
  }
  std::stable_sort(
      items.begin(), items.end(), [](const Item& a, const Item& b) {
        return a.projected.depth < b.projected.depth;
      });

  const int stride = 5 + model.num_features;
  std::vector<double> image(
      static_cast<size_t>(pinhole.width) * pinhole.height * stride, 0.0);
  for (int y = 0; y < pinhole.height; ++y) {
    for (int x = 0; x < pinhole.width; ++x) {
      double* pixel =
          &image[(static_cast<size_t>(y) * pinhole.width + x) * stride];
      double transmittance = 1;
      for (const Item& item : items) {
        const double dx = x + 0.5 - item.projected.mean[0];
        const double dy = y + 0.5 - item.projected.mean[1];
        const double sheared = dx + item.projected.shear * dy;
        const double q = item.projected.conic_xx * sheared * sheared +
                         item.projected.precision_y * dy * dy;
        const double alpha =
            std::min<double>(kMaxAlpha, item.opacity * std::exp(-0.5 * q));
        if (alpha < 1.0 / 255 || transmittance < kMinTransmittance) continue;
        const double weight = alpha * transmittance;
        transmittance -= weight;
        for (int c = 0; c < 3; ++c) pixel[c] += weight * item.color[c];
        pixel[4] += weight * item.projected.depth;
        for (int f = 0; f < model.num_features; ++f) {
          pixel[5 + f] +=
              weight * model.features[item.index * model.num_features + f];
        }
      }
      for (int c = 0; c < 3; ++c) {
        pixel[c] += transmittance * options.background[c];
      }
      pixel[3] = transmittance;
    }
  }
  return image;
}

}  // namespace freegs::splat

#endif  // FREEGS_TESTS_SPLAT_REFERENCE_RENDERER_H_
