// SPDX-License-Identifier: BSD-3-Clause
// The scene: a set of 3D Gaussians with view-dependent colour.
//
//   GaussianModel model;
//   model.sh_degree = 0;
//   model.Resize(1);
//   model.means = {0, 0, 2};           // Two units along z.
//   model.log_scales = {-3, -3, -3};   // Standard deviation e^-3.
//   model.rotations = {1, 0, 0, 0};    // No rotation.
//   model.opacity_logits = {4};        // Opacity 0.98.
//   model.sh_dc = {1, 0, 0};           // Reddish; see kShC0.

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
inline constexpr int kMaxShDegree = 3;

// Some programs train SH of a higher degree. Readers of files drop what the
// model does not hold.
inline constexpr int kMaxFileShDegree = 4;

// The colour of a Gaussian of degree 0 is kShC0 * sh_dc + 0.5 per channel.
inline constexpr float kShC0 = 0.28209479177387814f;

// The parameters that training optimises. Each kind has one flat array, which
// an optimiser can walk from end to end; Gaussian i owns the i-th group of
// numbers in each array. Positions and lengths are in the model frame
// (splat/scene/model_frame.h), or in the world in a PlacedModel.
struct GaussianModel {
  int sh_degree = 0;  // Degree of the coefficients in sh_rest, 0 to 3.

  // Whether the renderer keeps what a Gaussian adds to a picture the same when
  // its low-pass filter widens it (LogOpacityFilter in ewa_projection-inl.h). A
  // model looks right only when rendered as it was trained.
  bool antialiased = false;

  std::vector<float> means;           // N x 3.
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

  // Makes every array hold `count` Gaussians. New ones are all zeros.
  void Resize(size_t count);

  // Keeps only the Gaussians listed, in the order of the list.
  void Select(std::span<const uint32_t> indices);

  // A model of only these Gaussians, in the order of the list.
  GaussianModel Selected(std::span<const uint32_t> indices) const;

  // Appends a copy of Gaussian `index` of `other`, which must have the same SH
  // degree.
  void AppendFrom(const GaussianModel& other, size_t index);

  // Changes the stored SH degree. A higher degree adds coefficients of zero, a
  // lower one drops coefficients.
  void SetShDegree(int degree);

  // True when no parameter is NaN or infinite.
  bool AllFinite() const;
};

// The derivatives of the loss with respect to every parameter, in arrays of the
// same shapes as the model's.
using GaussianGradients = GaussianModel;

// The kinds of parameters, for code that treats all arrays alike, such as the
// optimiser and the checkpoints.
enum class Parameter {
  kMean,
  kLogScale,
  kRotation,
  kOpacityLogit,
  kShDc,
  kShRest
};
inline constexpr int kNumParameters = 6;
inline constexpr std::array<Parameter, kNumParameters> kAllParameters = {
    Parameter::kMean,
    Parameter::kLogScale,
    Parameter::kRotation,
    Parameter::kOpacityLogit,
    Parameter::kShDc,
    Parameter::kShRest};

std::vector<float>& ParameterArray(GaussianModel& model, Parameter parameter);
const std::vector<float>& ParameterArray(const GaussianModel& model,
                                         Parameter parameter);
// How many floats of this kind each Gaussian has.
int ParameterStride(const GaussianModel& model, Parameter parameter);

// The opacity of Gaussian `index`, from 0 to 1.
double Opacity(const GaussianModel& model, size_t index);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_SCENE_GAUSSIAN_MODEL_H_
