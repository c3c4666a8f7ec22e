// SPDX-License-Identifier: BSD-3-Clause
// The scene: a set of 3D Gaussians with view-dependent colour.

#ifndef FREEGS_SPLAT_SCENE_GAUSSIAN_MODEL_H_
#define FREEGS_SPLAT_SCENE_GAUSSIAN_MODEL_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace freegs::splat {

// Number of spherical-harmonics coefficients per colour channel.
constexpr int NumShCoefficients(int degree) {
  return (degree + 1) * (degree + 1);
}
constexpr int kMaxShDegree = 3;

// Colour = kShC0 * dc + 0.5 for a Gaussian of degree 0.
constexpr float kShC0 = 0.28209479177387814f;

// The optimised parameters, one flat array per kind (structure of arrays, so
// that an optimiser walks them linearly). Gaussian i owns the i-th group of
// each array. World units are those of the camera poses.
struct GaussianModel {
  int sh_degree = 0;  // Degree stored: sh_rest holds its coefficients.

  std::vector<float> means;           // N x 3, world frame.
  std::vector<float> log_scales;      // N x 3, natural log of the std. dev.
  std::vector<float> rotations;       // N x 4, w x y z, not normalised.
  std::vector<float> opacity_logits;  // N, opacity = 1 / (1 + exp(-logit)).
  std::vector<float> sh_dc;           // N x 3 (r g b), degree 0.
  std::vector<float> sh_rest;         // N x (K - 1) x 3, K = (degree + 1)^2;
                                      // coefficient-major: [k][channel].

  size_t size() const { return opacity_logits.size(); }
  bool empty() const { return opacity_logits.empty(); }

  // Floats of sh_rest per Gaussian.
  int sh_rest_stride() const { return 3 * (NumShCoefficients(sh_degree) - 1); }

  // Grows with zeros or cuts, every array.
  void Resize(size_t count);

  // Keeps the Gaussians listed (ascending or any order), drops the others.
  void Select(std::span<const uint32_t> indices);

  // Appends a copy of Gaussian `index` of `other`, of the same SH degree.
  void AppendFrom(const GaussianModel& other, size_t index);

  // Raises or lowers the stored SH degree; new coefficients are zero.
  void SetShDegree(int degree);

  // True when no parameter is NaN or infinite.
  bool AllFinite() const;
};

// d loss / d parameter, in arrays of a model's shapes.
using GaussianGradients = GaussianModel;

// The parameter arrays of a model by kind, for code that treats all alike
// (optimiser, checkpoints).
enum class Parameter {
  kMean,
  kLogScale,
  kRotation,
  kOpacityLogit,
  kShDc,
  kShRest
};
constexpr int kNumParameters = 6;
constexpr std::array<Parameter, kNumParameters> kAllParameters = {
    Parameter::kMean,
    Parameter::kLogScale,
    Parameter::kRotation,
    Parameter::kOpacityLogit,
    Parameter::kShDc,
    Parameter::kShRest};

std::vector<float>& ParameterArray(GaussianModel& model, Parameter parameter);
const std::vector<float>& ParameterArray(const GaussianModel& model,
                                         Parameter parameter);
// Floats per Gaussian.
int ParameterStride(const GaussianModel& model, Parameter parameter);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_SCENE_GAUSSIAN_MODEL_H_
