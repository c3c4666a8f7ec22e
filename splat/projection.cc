// SPDX-License-Identifier: BSD-3-Clause

#include "splat/projection.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "splat/spherical_harmonics.h"

namespace freegs::splat {
namespace {

constexpr int64_t kChunk = 1024;

// Added to the far ends of pixel boxes against rounding, pixels.
constexpr float kSlack = 1e-3f;

float Log2Opacity(float logit) {
  // log2(sigmoid(x)) = -log2(1 + exp(-x)), without overflow.
  const float log_opacity = logit >= 0 ? -std::log1p(std::exp(-logit))
                                       : logit - std::log1p(std::exp(logit));
  return log_opacity * 1.4426950408889634f;
}

// View-dependent colour (3DGS, section 5.1 of its supplement: 0.5 + SH, not
// below 0). basis receives the SH basis for the backward pass.
void EvaluateColor(const GaussianModel& model,
                   size_t i,
                   int degree,
                   const float direction[3],
                   float basis[15],
                   float color[3]) {
  const int count = NumShCoefficients(degree) - 1;
  EvaluateShBasis(degree, direction[0], direction[1], direction[2], basis);
  const float* rest = model.sh_rest.data() + i * model.sh_rest_stride();
  for (int c = 0; c < 3; ++c) {
    float value = 0.5f + kShC0 * model.sh_dc[3 * i + c];
    for (int k = 0; k < count; ++k) value += basis[k] * rest[3 * k + c];
    color[c] = value;
  }
}

struct Direction {
  float unit[3];
  float inverse_length;
};

Direction ViewDirection(const float mean[3], const float centre[3]) {
  Direction direction;
  float squared = 0;
  for (int i = 0; i < 3; ++i) {
    direction.unit[i] = mean[i] - centre[i];
    squared += direction.unit[i] * direction.unit[i];
  }
  direction.inverse_length = 1.0f / std::sqrt(std::max(squared, 1e-20f));
  for (float& v : direction.unit) v *= direction.inverse_length;
  return direction;
}

// The first pixel whose centre is not before `edge`, within [0, size].
int32_t FirstPixel(float edge, int size) {
  const float pixel = std::ceil(edge - 0.5f);
  return static_cast<int32_t>(
      std::clamp(pixel, 0.0f, static_cast<float>(size)));
}

// Fills *splat, or returns false when the Gaussian cannot touch a pixel.
bool MakeSplat(const GaussianModel& model,
               size_t i,
               const ProjectionCamera<float>& camera,
               const Pinhole& image,
               int sh_degree,
               Splat* splat) {
  const float log2_opacity = Log2Opacity(model.opacity_logits[i]);
  // Also rejects NaN.
  if (!(log2_opacity > std::log2(kMinAlpha))) return false;
  ProjectedGaussian<float> projected;
  ProjectionTerms<float> terms;
  if (!ProjectGaussian(camera,
                       &model.means[3 * i],
                       &model.log_scales[3 * i],
                       &model.rotations[4 * i],
                       &projected,
                       &terms)) {
    return false;
  }
  // alpha >= 1/255 where d^T conic d <= 2 ln(255 o): an ellipse with these
  // half-extents.
  const float reach =
      2.0f * (log2_opacity - std::log2(kMinAlpha)) / 1.4426950408889634f;
  splat->extent_x = std::sqrt(reach * projected.cov[0]);
  splat->extent_y = std::sqrt(reach * projected.cov[2]);
  splat->mean_x = projected.mean[0];
  splat->mean_y = projected.mean[1];
  const bool inside =
      splat->mean_x + splat->extent_x > 0.5f &&
      splat->mean_x - splat->extent_x <
          static_cast<float>(image.width) - 0.5f &&
      splat->mean_y + splat->extent_y > 0.5f &&
      splat->mean_y - splat->extent_y < static_cast<float>(image.height) - 0.5f;
  if (!inside) return false;
  splat->x_begin = FirstPixel(splat->mean_x - splat->extent_x, image.width);
  splat->x_end =
      FirstPixel(splat->mean_x + splat->extent_x + kSlack, image.width);
  splat->y_begin = FirstPixel(splat->mean_y - splat->extent_y, image.height);
  splat->y_end =
      FirstPixel(splat->mean_y + splat->extent_y + kSlack, image.height);
  splat->conic_xx = projected.conic[0];
  splat->conic_xy = projected.conic[1];
  splat->conic_yy = projected.conic[2];
  splat->log2_opacity = log2_opacity;
  splat->depth = projected.depth;
  const Direction direction = ViewDirection(&model.means[3 * i], camera.centre);
  float basis[15];
  EvaluateColor(model, i, sh_degree, direction.unit, basis, splat->color);
  for (float& c : splat->color) c = std::max(c, 0.0f);
  return true;
}

// Stable radix sort by the upper 32 bits of the keys, 11 bits a pass.
void SortByDepth(std::vector<uint64_t>* keys, std::vector<uint64_t>* scratch) {
  constexpr int kBits = 11;
  constexpr size_t kBuckets = size_t{1} << kBits;
  scratch->resize(keys->size());
  std::vector<uint32_t> starts(kBuckets);
  for (int shift = 32; shift < 64; shift += kBits) {
    std::fill(starts.begin(), starts.end(), 0);
    for (const uint64_t key : *keys) {
      ++starts[(key >> shift) & (kBuckets - 1)];
    }
    uint32_t sum = 0;
    for (uint32_t& start : starts) sum += std::exchange(start, sum);
    for (const uint64_t key : *keys) {
      (*scratch)[starts[(key >> shift) & (kBuckets - 1)]++] = key;
    }
    keys->swap(*scratch);
  }
}

}  // namespace

template <typename T>
ProjectionCamera<T> MakeProjectionCamera(const Pinhole& camera,
                                         const Rigid3d& cam_from_world,
                                         const RenderOptions& options) {
  ProjectionCamera<T> result;
  const Eigen::Matrix3d rotation = cam_from_world.rotation.toRotationMatrix();
  const Eigen::Vector3d centre = CameraCentre(cam_from_world);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      result.rotation[3 * i + j] = static_cast<T>(rotation(i, j));
    }
    result.translation[i] = static_cast<T>(cam_from_world.translation[i]);
    result.centre[i] = static_cast<T>(centre[i]);
  }
  result.fx = static_cast<T>(camera.fx);
  result.fy = static_cast<T>(camera.fy);
  result.cx = static_cast<T>(camera.cx);
  result.cy = static_cast<T>(camera.cy);
  // The image plus 15 % of its size on each side, as in 3DGS.
  const double margin_u = 0.15 * camera.width / camera.fx;
  const double margin_v = 0.15 * camera.height / camera.fy;
  result.min_u = static_cast<T>(-camera.cx / camera.fx - margin_u);
  result.max_u =
      static_cast<T>((camera.width - camera.cx) / camera.fx + margin_u);
  result.min_v = static_cast<T>(-camera.cy / camera.fy - margin_v);
  result.max_v =
      static_cast<T>((camera.height - camera.cy) / camera.fy + margin_v);
  result.near_plane = static_cast<T>(options.near_plane);
  result.dilation = static_cast<T>(options.dilation);
  return result;
}

template ProjectionCamera<float> MakeProjectionCamera(const Pinhole&,
                                                      const Rigid3d&,
                                                      const RenderOptions&);
template ProjectionCamera<double> MakeProjectionCamera(const Pinhole&,
                                                       const Rigid3d&,
                                                       const RenderOptions&);

void Projector::Project(const GaussianModel& model,
                        const Pinhole& camera,
                        const Rigid3d& cam_from_world,
                        const RenderOptions& options,
                        ThreadPool& pool,
                        Projection* projection) {
  const ProjectionCamera<float> projection_camera =
      MakeProjectionCamera<float>(camera, cam_from_world, options);
  const int sh_degree = std::min(options.sh_degree, model.sh_degree);
  const auto count = static_cast<int64_t>(model.size());
  by_model_.resize(model.size());
  visible_.resize(model.size());
  chunk_counts_.assign((model.size() + kChunk - 1) / kChunk, 0);
  pool.ParallelFor(0, count, kChunk, [&](int64_t begin, int64_t end, int) {
    uint32_t found = 0;
    for (int64_t i = begin; i < end; ++i) {
      if (MakeSplat(model,
                    static_cast<size_t>(i),
                    projection_camera,
                    camera,
                    sh_degree,
                    &by_model_[i])) {
        visible_[begin + found++] = static_cast<uint32_t>(i);
      }
    }
    chunk_counts_[begin / kChunk] = found;
  });

  keys_.clear();
  for (size_t chunk = 0; chunk < chunk_counts_.size(); ++chunk) {
    for (uint32_t k = 0; k < chunk_counts_[chunk]; ++k) {
      const uint32_t i = visible_[chunk * kChunk + k];
      // Positive floats sort as their bits.
      const auto depth = std::bit_cast<uint32_t>(by_model_[i].depth);
      keys_.push_back(static_cast<uint64_t>(depth) << 32 | i);
    }
  }
  SortByDepth(&keys_, &keys_scratch_);

  projection->splats.resize(keys_.size());
  projection->model_index.resize(keys_.size());
  pool.ParallelFor(0,
                   static_cast<int64_t>(keys_.size()),
                   kChunk,
                   [&](int64_t begin, int64_t end, int) {
                     for (int64_t k = begin; k < end; ++k) {
                       const auto i = static_cast<uint32_t>(keys_[k]);
                       projection->model_index[k] = i;
                       projection->splats[k] = by_model_[i];
                     }
                   });
}

namespace {

void BackwardSplat(const GaussianModel& model,
                   size_t i,
                   const ProjectionCamera<float>& camera,
                   int sh_degree,
                   const Splat& splat,
                   const float* moments,
                   const SplatMoments& layout,
                   GaussianModel* gradients,
                   float* mean2d_gradient) {
  ProjectedGaussian<float> projected;
  ProjectionTerms<float> terms;
  float* d_mean = &gradients->means[3 * i];
  float* d_log_scale = &gradients->log_scales[3 * i];
  std::fill_n(d_mean, 3, 0.0f);
  std::fill_n(d_log_scale, 3, 0.0f);
  // Succeeds: the forward pass did with the same numbers.
  ProjectGaussian(camera,
                  &model.means[3 * i],
                  &model.log_scales[3 * i],
                  &model.rotations[4 * i],
                  &projected,
                  &terms);

  // ln(alpha) = ln(o) - (xx dx^2 + 2 xy dx dy + yy dy^2) / 2 with d = pixel -
  // mean; the moments are sums of dL/dln(alpha) times powers of d.
  ProjectedGradient<float> gradient;
  gradient.mean[0] = splat.conic_xx * moments[1] + splat.conic_xy * moments[2];
  gradient.mean[1] = splat.conic_xy * moments[1] + splat.conic_yy * moments[2];
  gradient.conic[0] = -0.5f * moments[3];
  gradient.conic[1] = -moments[4];
  gradient.conic[2] = -0.5f * moments[5];
  if (layout.depth_extra >= 0) {
    gradient.depth = moments[kMomentStride + layout.depth_extra];
  }
  if (mean2d_gradient != nullptr) {
    mean2d_gradient[0] = gradient.mean[0];
    mean2d_gradient[1] = gradient.mean[1];
  }
  // d ln(sigmoid(x)) / dx = 1 - sigmoid(x).
  gradients->opacity_logits[i] =
      moments[0] * (1.0f - std::exp2(splat.log2_opacity));

  const Direction direction = ViewDirection(&model.means[3 * i], camera.centre);
  float basis[15];
  float color[3];
  EvaluateColor(model, i, sh_degree, direction.unit, basis, color);
  const int count = NumShCoefficients(sh_degree) - 1;
  const int stride = model.sh_rest_stride();
  const float* rest = model.sh_rest.data() + i * stride;
  float* d_rest = gradients->sh_rest.data() + i * stride;
  std::fill_n(d_rest, stride, 0.0f);
  float basis_gradient[15] = {};
  for (int c = 0; c < 3; ++c) {
    const float d_color = color[c] > 0.0f ? moments[kNumMoments + c] : 0.0f;
    gradients->sh_dc[3 * i + c] = kShC0 * d_color;
    for (int k = 0; k < count; ++k) {
      d_rest[3 * k + c] = basis[k] * d_color;
      basis_gradient[k] += rest[3 * k + c] * d_color;
    }
  }
  if (count > 0) {
    float d_direction[3] = {0, 0, 0};
    BackwardShBasis(sh_degree,
                    direction.unit[0],
                    direction.unit[1],
                    direction.unit[2],
                    basis_gradient,
                    &d_direction[0],
                    &d_direction[1],
                    &d_direction[2]);
    float along = 0;
    for (int k = 0; k < 3; ++k) along += d_direction[k] * direction.unit[k];
    for (int k = 0; k < 3; ++k) {
      d_mean[k] += (d_direction[k] - along * direction.unit[k]) *
                   direction.inverse_length;
    }
  }
  BackwardProjectGaussian(camera,
                          projected,
                          terms,
                          gradient,
                          d_mean,
                          d_log_scale,
                          &gradients->rotations[4 * i]);
}

}  // namespace

void BackwardProjection(const GaussianModel& model,
                        const Pinhole& camera,
                        const Rigid3d& cam_from_world,
                        const RenderOptions& options,
                        const Projection& projection,
                        const SplatMoments& moments,
                        ThreadPool& pool,
                        GaussianModel* gradients,
                        std::span<float> mean2d_gradients) {
  const ProjectionCamera<float> projection_camera =
      MakeProjectionCamera<float>(camera, cam_from_world, options);
  const int sh_degree = std::min(options.sh_degree, model.sh_degree);
  pool.ParallelFor(0,
                   static_cast<int64_t>(projection.size()),
                   kChunk / 4,
                   [&](int64_t begin, int64_t end, int) {
                     for (int64_t k = begin; k < end; ++k) {
                       BackwardSplat(model,
                                     projection.model_index[k],
                                     projection_camera,
                                     sh_degree,
                                     projection.splats[k],
                                     moments.values.data() + k * moments.stride,
                                     moments,
                                     gradients,
                                     mean2d_gradients.empty()
                                         ? nullptr
                                         : &mean2d_gradients[2 * k]);
                     }
                   });
}

}  // namespace freegs::splat
