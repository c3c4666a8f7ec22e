// SPDX-License-Identifier: BSD-3-Clause

#include "splat/projection/projection_simd.h"

#include <algorithm>
#include <cmath>

#include <hwy/cache_control.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/projection/projection_simd.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/projection/ewa_projection-inl.h"
#include "splat/projection/simd_number-inl.h"
#include "splat/projection/spherical_harmonics-inl.h"

HWY_BEFORE_NAMESPACE();
namespace freegs::splat::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Tag = SimdNumber::Tag;
constexpr size_t kMaxLanes = 16;
constexpr float kLn2 = 0.6931471805599453f;
constexpr float kMinLog2Alpha = -7.994353436858858f;  // log2(1 / 255).

// Added to the far ends of the pixel boxes, in pixels, to make up for rounding.
constexpr float kSlack = 1e-3f;

// Numbers of a group of Gaussians; those of one kind lie side by side.
struct alignas(64) LaneArray {
  float values[kMaxLanes];
};

HWY_INLINE SimdNumber FromArray(const LaneArray& array) {
  return hn::Load(Tag(), array.values);
}
HWY_INLINE void ToArray(SimdNumber number, LaneArray* array) {
  hn::Store(number.vector, Tag(), array->values);
}

ProjectionCamera<SimdNumber> Broadcast(const ProjectionCamera<float>& from) {
  ProjectionCamera<SimdNumber> to;
  for (int i = 0; i < 9; ++i) to.rotation[i] = SimdNumber(from.rotation[i]);
  for (int i = 0; i < 3; ++i) {
    to.translation[i] = SimdNumber(from.translation[i]);
    to.centre[i] = SimdNumber(from.centre[i]);
  }
  to.fx = SimdNumber(from.fx);
  to.fy = SimdNumber(from.fy);
  to.cx = SimdNumber(from.cx);
  to.cy = SimdNumber(from.cy);
  to.min_u = SimdNumber(from.min_u);
  to.max_u = SimdNumber(from.max_u);
  to.min_v = SimdNumber(from.min_v);
  to.max_v = SimdNumber(from.max_v);
  to.near_plane = SimdNumber(from.near_plane);
  to.dilation = SimdNumber(from.dilation);
  return to;
}

// A group of Gaussians: as many as a vector has lanes, or fewer at the end.
struct Group {
  const uint32_t* indices;  // Rows of a model, or of gradients.
  size_t count;
  bool consecutive;  // A whole vector of neighbours.
};

HWY_INLINE Group MakeGroup(const uint32_t* indices, size_t count) {
  const size_t lanes = hn::Lanes(Tag());
  Group group{indices, std::min(count, lanes), false};
  group.consecutive =
      group.count == lanes && indices[lanes - 1] - indices[0] == lanes - 1;
  return group;
}

// Rows of 3 or 4 floats of a model's array, into as many numbers. Lanes beyond
// the group are zero.
template <int kStride>
HWY_INLINE void LoadRows(const Group& group,
                         const float* array,
                         SimdNumber out[kStride]) {
  const Tag d;
  HWY_ALIGN float rows[kStride * kMaxLanes];
  const float* from = array + static_cast<size_t>(group.indices[0]) * kStride;
  if (!group.consecutive) {
    std::fill_n(rows, kStride * kMaxLanes, 0.0f);
    for (size_t l = 0; l < group.count; ++l) {
      const float* row =
          array + static_cast<size_t>(group.indices[l]) * kStride;
      for (int k = 0; k < kStride; ++k) rows[kStride * l + k] = row[k];
    }
    from = rows;
  }
  if constexpr (kStride == 3) {
    hn::LoadInterleaved3(d, from, out[0].vector, out[1].vector, out[2].vector);
  } else {
    hn::LoadInterleaved4(
        d, from, out[0].vector, out[1].vector, out[2].vector, out[3].vector);
  }
}

template <int kStride>
HWY_INLINE void StoreRows(const Group& group,
                          const SimdNumber values[kStride],
                          float* array) {
  const Tag d;
  HWY_ALIGN float rows[kStride * kMaxLanes];
  float* to = group.consecutive
                  ? array + static_cast<size_t>(group.indices[0]) * kStride
                  : rows;
  if constexpr (kStride == 3) {
    hn::StoreInterleaved3(
        values[0].vector, values[1].vector, values[2].vector, d, to);
  } else {
    hn::StoreInterleaved4(values[0].vector,
                          values[1].vector,
                          values[2].vector,
                          values[3].vector,
                          d,
                          to);
  }
  if (group.consecutive) return;
  for (size_t l = 0; l < group.count; ++l) {
    float* row = array + static_cast<size_t>(group.indices[l]) * kStride;
    for (int k = 0; k < kStride; ++k) row[k] = rows[kStride * l + k];
  }
}

struct Direction {
  SimdNumber unit[3];
  SimdNumber inverse_length;
};

HWY_INLINE Direction ViewDirection(const SimdNumber mean[3],
                                   const ProjectionCamera<SimdNumber>& camera) {
  Direction direction;
  SimdNumber squared(1e-20f);
  for (int i = 0; i < 3; ++i) {
    direction.unit[i] = mean[i] - camera.centre[i];
    squared += direction.unit[i] * direction.unit[i];
  }
  direction.inverse_length = SimdNumber(1.0f) / sqrt(squared);
  for (SimdNumber& v : direction.unit) v = v * direction.inverse_length;
  return direction;
}

// The SH basis above degree 0 of a group, [coefficient][lane].
struct Basis {
  LaneArray values[15];
};

HWY_INLINE void MakeBasis(int degree,
                          const Direction& direction,
                          Basis* basis) {
  SimdNumber values[15];
  EvaluateShBasis(
      degree, direction.unit[0], direction.unit[1], direction.unit[2], values);
  for (int k = 0; k + 1 < NumShCoefficients(degree); ++k) {
    ToArray(values[k], &basis->values[k]);
  }
}

// The members of Splat in their order; those of one kind lie side by side.
struct SplatLanes {
  LaneArray mean[2], conic[3], log2_opacity, extent[2], color[3], depth;
  LaneArray box[4];  // Whole numbers.
};

Splat LaneOf(const SplatLanes& lanes, size_t l) {
  Splat splat;
  splat.mean_x = lanes.mean[0].values[l];
  splat.mean_y = lanes.mean[1].values[l];
  splat.conic_xx = lanes.conic[0].values[l];
  splat.conic_xy = lanes.conic[1].values[l];
  splat.conic_yy = lanes.conic[2].values[l];
  splat.log2_opacity = lanes.log2_opacity.values[l];
  splat.extent_x = lanes.extent[0].values[l];
  splat.extent_y = lanes.extent[1].values[l];
  for (int c = 0; c < 3; ++c) splat.color[c] = lanes.color[c].values[l];
  splat.depth = lanes.depth.values[l];
  splat.x_begin = static_cast<int32_t>(lanes.box[0].values[l]);
  splat.x_end = static_cast<int32_t>(lanes.box[1].values[l]);
  splat.y_begin = static_cast<int32_t>(lanes.box[2].values[l]);
  splat.y_end = static_cast<int32_t>(lanes.box[3].values[l]);
  return splat;
}

// The first pixel whose centre is not before `edge`, within [0, size].
HWY_INLINE SimdNumber FirstPixel(SimdNumber edge, SimdNumber size) {
  return Min(Max(ceil(edge - SimdNumber(0.5f)), SimdNumber(0.0f)), size);
}

// Adds the view-dependent part of the colour, and raises negative colours to 0
// as 3DGS does.
void FinishColor(const ProjectionTask& task,
                 size_t i,
                 const Basis& basis,
                 size_t lane,
                 float color[3]) {
  const int count = NumShCoefficients(task.sh_degree) - 1;
  const float* rest =
      task.model->sh_rest.data() + i * task.model->sh_rest_stride();
  float red = color[0], green = color[1], blue = color[2];
  for (int k = 0; k < count; ++k) {
    const float value = basis.values[k].values[lane];
    red += value * rest[3 * k];
    green += value * rest[3 * k + 1];
    blue += value * rest[3 * k + 2];
  }
  color[0] = std::max(red, 0.0f);
  color[1] = std::max(green, 0.0f);
  color[2] = std::max(blue, 0.0f);
}

// Computes all of the splats of a group but the view-dependent colour. Returns
// which lanes can touch a pixel.
HWY_INLINE SimdMask ProjectGroup(const ProjectionTask& task,
                                 const ProjectionCamera<SimdNumber>& camera,
                                 const Group& group,
                                 SplatLanes* lanes,
                                 Basis* basis) {
  const GaussianModel& model = *task.model;
  SimdNumber mean[3], log_scale[3], rotation[4], dc[3];
  LoadRows<3>(group, model.means.data(), mean);
  LoadRows<3>(group, model.log_scales.data(), log_scale);
  LoadRows<4>(group, model.rotations.data(), rotation);
  LoadRows<3>(group, model.sh_dc.data(), dc);
  LaneArray logits = {};
  std::copy_n(
      &model.opacity_logits[group.indices[0]], group.count, logits.values);

  // log2(sigmoid(x)); minus infinity where exp overflows.
  const SimdNumber log2_opacity =
      -log1p(exp(-FromArray(logits))) * SimdNumber(1 / kLn2);
  ProjectedGaussian<SimdNumber> projected;
  ProjectionTerms<SimdNumber> terms;
  SimdMask visible =
      ProjectGaussian(camera, mean, log_scale, rotation, &projected, &terms);
  visible = And(visible, log2_opacity > SimdNumber(kMinLog2Alpha));
  // alpha >= 1/255 where d^T conic d <= 2 ln(255 o): an ellipse with these
  // half-extents.
  const SimdNumber reach =
      SimdNumber(2 * kLn2) * (log2_opacity - SimdNumber(kMinLog2Alpha));
  const SimdNumber size[2] = {SimdNumber(task.width), SimdNumber(task.height)};
  for (int axis = 0; axis < 2; ++axis) {
    const SimdNumber extent = sqrt(reach * projected.cov[2 * axis]);
    const SimdNumber low = projected.mean[axis] - extent;
    const SimdNumber high = projected.mean[axis] + extent;
    const SimdNumber half(0.5f);
    visible = And(visible, And(high > half, size[axis] - half > low));
    ToArray(extent, &lanes->extent[axis]);
    ToArray(projected.mean[axis], &lanes->mean[axis]);
    ToArray(FirstPixel(low, size[axis]), &lanes->box[2 * axis]);
    ToArray(FirstPixel(high + SimdNumber(kSlack), size[axis]),
            &lanes->box[2 * axis + 1]);
  }
  for (int k = 0; k < 3; ++k) ToArray(projected.conic[k], &lanes->conic[k]);
  ToArray(log2_opacity, &lanes->log2_opacity);
  ToArray(projected.depth, &lanes->depth);
  for (int c = 0; c < 3; ++c) {
    ToArray(SimdNumber(0.5f) + SimdNumber(kShC0) * dc[c], &lanes->color[c]);
  }
  if (task.sh_degree > 0) {
    MakeBasis(task.sh_degree, ViewDirection(mean, camera), basis);
  }
  return visible;
}

size_t Project(const ProjectionTask& task,
               size_t begin,
               size_t end,
               Splat* splats,
               uint32_t* visible) {
  const ProjectionCamera<SimdNumber> camera = Broadcast(task.camera);
  const size_t num_lanes = hn::Lanes(Tag());
  SplatLanes lanes;
  Basis basis;
  size_t found = 0;
  uint32_t indices[kMaxLanes];
  for (size_t i = begin; i < end; i += num_lanes) {
    const size_t count = std::min(num_lanes, end - i);
    for (size_t l = 0; l < count; ++l) {
      indices[l] = static_cast<uint32_t>(i + l);
    }
    const SimdMask mask =
        ProjectGroup(task, camera, MakeGroup(indices, count), &lanes, &basis);
    LaneArray flags = {};
    ToArray(Select(mask, SimdNumber(1.0f), SimdNumber(0.0f)), &flags);
    for (size_t l = 0; l < count; ++l) {
      if (flags.values[l] == 0.0f) continue;
      Splat splat = LaneOf(lanes, l);
      FinishColor(task, i + l, basis, l, splat.color);
      splats[i + l] = splat;
      visible[found++] = static_cast<uint32_t>(i + l);
    }
  }
  return found;
}

// SplatSums, [member][lane].
struct SumLanes {
  LaneArray moments[kMomentStride];
  LaneArray log2_opacity;
  LaneArray depth_gradient;
};

HWY_INLINE void GatherSums(const ProjectionBackwardTask& task,
                           size_t first,
                           size_t count,
                           SumLanes* lanes) {
  for (size_t l = 0; l < count; ++l) {
    const SplatSums& sums = task.sums[task.rank[first + l]];
    for (int m = 0; m < kMomentStride; ++m) {
      lanes->moments[m].values[l] = sums.moments[m];
    }
    lanes->log2_opacity.values[l] = sums.log2_opacity;
    lanes->depth_gradient.values[l] = sums.depth_gradient;
  }
}

// Writes the gradients of the rows of sh_rest, and dL/dbasis of every lane.
void BackwardRest(const ProjectionBackwardTask& task,
                  const Group& group,
                  const Group& rows,
                  const SumLanes& sums,
                  const Basis& basis,
                  Basis* basis_gradient) {
  const GaussianModel& model = *task.forward.model;
  const int stride = model.sh_rest_stride();
  const int count = NumShCoefficients(task.forward.sh_degree) - 1;
  for (size_t l = 0; l < group.count; ++l) {
    const float* rest =
        model.sh_rest.data() + static_cast<size_t>(group.indices[l]) * stride;
    float* d_rest = task.gradients->sh_rest.data() +
                    static_cast<size_t>(rows.indices[l]) * stride;
    const float r = sums.moments[kNumMoments].values[l];
    const float g = sums.moments[kNumMoments + 1].values[l];
    const float b = sums.moments[kNumMoments + 2].values[l];
    for (int k = 0; k < count; ++k) {
      const float value = basis.values[k].values[l];
      d_rest[3 * k] = value * r;
      d_rest[3 * k + 1] = value * g;
      d_rest[3 * k + 2] = value * b;
      basis_gradient->values[k].values[l] =
          rest[3 * k] * r + rest[3 * k + 1] * g + rest[3 * k + 2] * b;
    }
    std::fill(d_rest + 3 * count, d_rest + stride, 0.0f);
  }
}

// Adds the part of dL/dmean that comes from the viewing direction.
HWY_INLINE void BackwardDirection(int sh_degree,
                                  const Direction& direction,
                                  const Basis& basis_gradient,
                                  SimdNumber d_mean[3]) {
  SimdNumber weights[15];
  for (int k = 0; k + 1 < NumShCoefficients(sh_degree); ++k) {
    weights[k] = FromArray(basis_gradient.values[k]);
  }
  const SimdNumber zero(0.0f);
  SimdNumber d[3] = {zero, zero, zero};
  BackwardShBasis(sh_degree,
                  direction.unit[0],
                  direction.unit[1],
                  direction.unit[2],
                  weights,
                  &d[0],
                  &d[1],
                  &d[2]);
  const SimdNumber along = d[0] * direction.unit[0] + d[1] * direction.unit[1] +
                           d[2] * direction.unit[2];
  for (int k = 0; k < 3; ++k) {
    d_mean[k] += (d[k] - along * direction.unit[k]) * direction.inverse_length;
  }
}

void BackwardGroup(const ProjectionBackwardTask& task,
                   const ProjectionCamera<SimdNumber>& camera,
                   size_t first,
                   const Group& group,
                   const Group& rows) {
  const GaussianModel& model = *task.forward.model;
  SimdNumber mean[3], log_scale[3], rotation[4];
  LoadRows<3>(group, model.means.data(), mean);
  LoadRows<3>(group, model.log_scales.data(), log_scale);
  LoadRows<4>(group, model.rotations.data(), rotation);
  SumLanes lanes = {};
  GatherSums(task, first, group.count, &lanes);
  SimdNumber moments[kMomentStride];
  for (int m = 0; m < kMomentStride; ++m)
    moments[m] = FromArray(lanes.moments[m]);

  ProjectedGaussian<SimdNumber> projected;
  ProjectionTerms<SimdNumber> terms;
  // Returns true in every lane, as it did in the forward pass with the same
  // numbers.
  ProjectGaussian(camera, mean, log_scale, rotation, &projected, &terms);

  // ln(alpha) = ln(o) - (xx dx^2 + 2 xy dx dy + yy dy^2) / 2 with d = pixel -
  // mean; the moments are sums of dL/dln(alpha) times powers of d.
  const SimdNumber* conic = projected.conic;
  ProjectedGradient<SimdNumber> gradient;
  gradient.mean[0] = conic[0] * moments[1] + conic[1] * moments[2];
  gradient.mean[1] = conic[1] * moments[1] + conic[2] * moments[2];
  gradient.conic[0] = SimdNumber(-0.5f) * moments[3];
  gradient.conic[1] = -moments[4];
  gradient.conic[2] = SimdNumber(-0.5f) * moments[5];
  gradient.depth = FromArray(lanes.depth_gradient);
  LaneArray x = {}, y = {};
  ToArray(gradient.mean[0], &x);
  ToArray(gradient.mean[1], &y);
  for (size_t l = 0; l < group.count; ++l) {
    float* out = task.mean2d_gradients + 2 * size_t{task.rank[first + l]};
    out[0] = x.values[l];
    out[1] = y.values[l];
  }

  // d ln(sigmoid(x)) / dx = 1 - sigmoid(x).
  LaneArray d_logit = {};
  const SimdNumber opacity =
      exp(FromArray(lanes.log2_opacity) * SimdNumber(kLn2));
  ToArray(moments[0] * (SimdNumber(1.0f) - opacity), &d_logit);
  for (size_t l = 0; l < group.count; ++l) {
    task.gradients->opacity_logits[rows.indices[l]] = d_logit.values[l];
  }

  const SimdNumber zero(0.0f);
  SimdNumber d_dc[3];
  for (int c = 0; c < 3; ++c) {
    d_dc[c] = SimdNumber(kShC0) * moments[kNumMoments + c];
  }
  StoreRows<3>(rows, d_dc, task.gradients->sh_dc.data());
  SimdNumber d_mean[3] = {zero, zero, zero};
  Basis basis, basis_gradient;
  if (task.forward.sh_degree > 0) {
    const Direction direction = ViewDirection(mean, camera);
    MakeBasis(task.forward.sh_degree, direction, &basis);
    BackwardRest(task, group, rows, lanes, basis, &basis_gradient);
    BackwardDirection(
        task.forward.sh_degree, direction, basis_gradient, d_mean);
  } else if (model.sh_degree > 0) {
    BackwardRest(task, group, rows, lanes, basis, &basis_gradient);
  }
  SimdNumber d_log_scale[3] = {zero, zero, zero};
  SimdNumber d_rotation[4];
  BackwardProjectGaussian(
      camera, projected, terms, gradient, d_mean, d_log_scale, d_rotation);
  StoreRows<3>(rows, d_mean, task.gradients->means.data());
  StoreRows<3>(rows, d_log_scale, task.gradients->log_scales.data());
  StoreRows<4>(rows, d_rotation, task.gradients->rotations.data());
}

void Backward(const ProjectionBackwardTask& task) {
  const ProjectionCamera<SimdNumber> camera = Broadcast(task.forward.camera);
  for (size_t j = 0; j < task.count; ++j) {
    hwy::Prefetch(task.sums + task.rank[j]);
  }
  for (size_t j = 0; j < task.count; j += hn::Lanes(Tag())) {
    BackwardGroup(task,
                  camera,
                  j,
                  MakeGroup(task.visible + j, task.count - j),
                  MakeGroup(task.rows + j, task.count - j));
  }
}

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace freegs::splat {

HWY_EXPORT(Project);
HWY_EXPORT(Backward);

size_t ProjectRange(const ProjectionTask& task,
                    size_t begin,
                    size_t end,
                    Splat* splats,
                    uint32_t* visible) {
  return HWY_DYNAMIC_DISPATCH(Project)(task, begin, end, splats, visible);
}

void BackwardProjection(const ProjectionBackwardTask& task) {
  HWY_DYNAMIC_DISPATCH(Backward)(task);
}

}  // namespace freegs::splat
#endif  // HWY_ONCE
