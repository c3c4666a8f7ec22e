// SPDX-License-Identifier: BSD-3-Clause

#include "splat/projection/projection_simd.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <hwy/cache_control.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/projection/projection_simd.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "splat/projection/ewa_projection-inl.h"
#include "splat/projection/row_lanes-inl.h"
#include "splat/projection/simd_number-inl.h"
#include "splat/projection/spherical_harmonics-inl.h"

HWY_BEFORE_NAMESPACE();
namespace freegs::splat::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Tag = SimdNumber::Tag;
constexpr float kLn2 = 0.6931471805599453f;

// Added to the ends of the pixel boxes, in pixels, to make up for rounding.
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

// Writes a splat of each lane to the rows. shape: conic_xx, shear and
// precision_y.
HWY_INLINE void StoreSplats(const SimdNumber mean[2],
                            const SimdNumber shape[3],
                            SimdNumber log2_opacity,
                            const SimdNumber extent[2],
                            const SimdNumber color[3],
                            SimdNumber depth,
                            const SimdNumber box[4],
                            const LaneRows<float>& splats) {
  const Tag d;
  const hn::RebindToSigned<Tag> di;
  const SimdNumber first[4] = {mean[0], mean[1], shape[0], shape[1]};
  const SimdNumber second[4] = {shape[2], log2_opacity, extent[0], extent[1]};
  const SimdNumber third[4] = {color[0], color[1], color[2], depth};
  SimdNumber fourth[4];
  for (int k = 0; k < 4; ++k) {
    fourth[k] = hn::BitCast(d, hn::ConvertTo(di, box[k].vector));
  }
  StoreColumns(first, splats, 0);
  StoreColumns(second, splats, 4);
  StoreColumns(third, splats, 8);
  StoreColumns(fourth, splats, 12);
}
static_assert(sizeof(Splat) == 16 * sizeof(float) &&
              offsetof(Splat, conic_xx) == 2 * sizeof(float) &&
              offsetof(Splat, log2_opacity) == 5 * sizeof(float) &&
              offsetof(Splat, extent_x) == 6 * sizeof(float) &&
              offsetof(Splat, color) == 8 * sizeof(float) &&
              offsetof(Splat, depth) == 11 * sizeof(float) &&
              offsetof(Splat, x_begin) == 12 * sizeof(float));

// The first pixel whose centre is not before `edge`, within [0, size].
HWY_INLINE SimdNumber FirstPixel(SimdNumber edge, SimdNumber size) {
  return Min(Max(ceil(edge - SimdNumber(0.5f)), SimdNumber(0.0f)), size);
}

// The rows of sh_rest of a group. Lanes beyond it repeat its first row.
HWY_INLINE LaneRows<const float> RestRows(const GaussianModel& model,
                                          const Group& group) {
  const size_t stride = static_cast<size_t>(model.sh_rest_stride());
  LaneRows<const float> rows;
  for (size_t l = 0; l < kMaxLanes; ++l) {
    const size_t index = group.indices[l < group.count ? l : 0];
    rows.of_lane[l] = model.sh_rest.data() + index * stride;
  }
  return rows;
}

// Requests the rows of sh_rest of a group from memory. They are most of what is
// read of a Gaussian, and all lanes are read at once, which keeps the processor
// from seeing what comes next by itself.
HWY_INLINE void PrefetchRest(const GaussianModel& model,
                             const uint32_t* indices,
                             size_t count) {
  constexpr size_t kLine = 64 / sizeof(float);
  const size_t stride = static_cast<size_t>(model.sh_rest_stride());
  for (size_t l = 0; l < std::min(count, kMaxLanes); ++l) {
    const float* row = model.sh_rest.data() + indices[l] * stride;
    for (size_t k = 0; k < stride; k += kLine) hwy::Prefetch(row + k);
  }
}

// Projects a group; splats and Gaussians have the same places. Returns which
// lanes can touch a pixel.
HWY_INLINE SimdMask ProjectGroup(const ProjectionTask& task,
                                 const ProjectionCamera<SimdNumber>& camera,
                                 const Group& group,
                                 Splat* splats) {
  const GaussianModel& model = *task.model;
  SimdNumber mean[3], log_scale[3], rotation[4], dc[3];
  LoadRows<3>(group, model.means.data(), mean);
  LoadRows<3>(group, model.log_scales.data(), log_scale);
  LoadRows<4>(group, model.rotations.data(), rotation);
  LoadRows<3>(group, model.sh_dc.data(), dc);
  LaneArray logits = {};
  std::copy_n(
      &model.opacity_logits[group.indices[0]], group.count, logits.values);

  // log2(sigmoid(x)).
  SimdNumber log2_opacity =
      -log1p(exp(-FromArray(logits))) * SimdNumber(1 / kLn2);
  ProjectedGaussian<SimdNumber> projected;
  ProjectionTerms<SimdNumber> terms;
  SimdMask visible =
      ProjectGaussian(camera, mean, log_scale, rotation, &projected, &terms);
  if (model.antialiased) {
    log2_opacity += LogOpacityFilter(terms) * SimdNumber(1 / kLn2);
  }
  visible = And(visible, log2_opacity > SimdNumber(kMinLog2Alpha));
  // alpha >= 1/255 where d^T conic d <= 2 ln(255 o): an ellipse with these
  // half-extents.
  const SimdNumber reach =
      SimdNumber(2 * kLn2) * (log2_opacity - SimdNumber(kMinLog2Alpha));
  const SimdNumber size[2] = {SimdNumber(task.width), SimdNumber(task.height)};
  SimdNumber extent[2], box[4];
  for (int axis = 0; axis < 2; ++axis) {
    extent[axis] = sqrt(reach * projected.cov[2 * axis]);
    const SimdNumber low = projected.mean[axis] - extent[axis];
    const SimdNumber high = projected.mean[axis] + extent[axis];
    const SimdNumber half(0.5f);
    visible = And(visible, And(high > half, size[axis] - half > low));
    box[2 * axis] = FirstPixel(low - SimdNumber(kSlack), size[axis]);
    box[2 * axis + 1] = FirstPixel(high + SimdNumber(kSlack), size[axis]);
  }
  if (hn::AllFalse(Tag(), visible.mask)) return visible;

  SimdNumber color[3];
  for (int c = 0; c < 3; ++c) {
    color[c] = SimdNumber(0.5f) + SimdNumber(kShC0) * dc[c];
  }
  if (task.sh_degree > 0) {
    const Direction direction = ViewDirection(mean, camera);
    SimdNumber basis[15];
    EvaluateShBasis(task.sh_degree,
                    direction.unit[0],
                    direction.unit[1],
                    direction.unit[2],
                    basis);
    ForEachColor(RestRows(model, group),
                 NumShCoefficients(task.sh_degree) - 1,
                 [&](int k, const SimdNumber* rest) HWY_ATTR {
                   for (int c = 0; c < 3; ++c) color[c] += basis[k] * rest[c];
                 });
  }
  // Negative colours are raised to 0, as in 3DGS.
  for (SimdNumber& value : color) value = Max(value, SimdNumber(0.0f));

  LaneRows<float> rows;
  Splat unused;
  for (size_t l = 0; l < kMaxLanes; ++l) {
    Splat* splat = l < group.count ? splats + group.indices[l] : &unused;
    rows.of_lane[l] = reinterpret_cast<float*>(splat);
  }
  const SimdNumber shape[3] = {
      projected.conic_xx, projected.shear, projected.precision_y};
  StoreSplats(projected.mean,
              shape,
              log2_opacity,
              extent,
              color,
              projected.depth,
              box,
              rows);
  return visible;
}

size_t Project(const ProjectionTask& task,
               size_t begin,
               size_t end,
               Splat* splats,
               uint32_t* visible) {
  const ProjectionCamera<SimdNumber> camera = Broadcast(task.camera);
  const size_t num_lanes = hn::Lanes(Tag());
  size_t found = 0;
  uint32_t indices[kMaxLanes], ahead[kMaxLanes];
  for (size_t i = begin; i < end; i += num_lanes) {
    const size_t count = std::min(num_lanes, end - i);
    for (size_t l = 0; l < count; ++l) {
      indices[l] = static_cast<uint32_t>(i + l);
      ahead[l] =
          static_cast<uint32_t>(std::min(i + l + 2 * num_lanes, end - 1));
    }
    PrefetchRest(*task.model, ahead, count);
    const SimdMask mask =
        ProjectGroup(task, camera, MakeGroup(indices, count), splats);
    LaneArray flags = {};
    ToArray(Select(mask, SimdNumber(1.0f), SimdNumber(0.0f)), &flags);
    for (size_t l = 0; l < count; ++l) {
      visible[found] = static_cast<uint32_t>(i + l);
      if (flags.values[l] != 0.0f) ++found;
    }
  }
  return found;
}

// SplatSums of a group of entries, one per lane.
struct SumLanes {
  SimdNumber moments[kMomentStride];
  SimdNumber depth_gradient;
};
static_assert(offsetof(SplatSums, depth_gradient) ==
                  kMomentStride * sizeof(float) &&
              kMomentStride == 9);

// Entries from `first` on; lanes beyond them repeat the first one.
HWY_INLINE void GatherSums(const ProjectionBackwardTask& task,
                           size_t first,
                           size_t count,
                           SumLanes* lanes) {
  LaneRows<const float> rows;
  for (size_t l = 0; l < kMaxLanes; ++l) {
    const size_t entry = first + (l < count ? l : 0);
    rows.of_lane[l] = reinterpret_cast<const float*>(task.sums + entry);
  }
  SimdNumber last[4];
  LoadColumns(rows, 0, lanes->moments);
  LoadColumns(rows, 4, lanes->moments + 4);
  LoadColumns(rows, 8, last);
  lanes->moments[8] = last[0];
  lanes->depth_gradient = last[1];
}

// Writes the gradients of the rows of sh_rest from dL/dcolor, and sums up
// dL/dbasis.
HWY_INLINE void BackwardRest(const ProjectionBackwardTask& task,
                             const Group& group,
                             const Group& rows,
                             const SimdNumber d_color[3],
                             const SimdNumber basis[15],
                             SimdNumber basis_gradient[15]) {
  const GaussianModel& model = *task.forward.model;
  const int stride = model.sh_rest_stride();
  const int count = NumShCoefficients(task.forward.sh_degree) - 1;
  ForEachColor(RestRows(model, group),
               count,
               [&](int k, const SimdNumber* rest) HWY_ATTR {
                 basis_gradient[k] = rest[0] * d_color[0] +
                                     rest[1] * d_color[1] +
                                     rest[2] * d_color[2];
               });
  LaneRows<float> d_rest;
  float unused[3 * (NumShCoefficients(kMaxShDegree) - 1)];
  for (size_t l = 0; l < kMaxLanes; ++l) {
    d_rest.of_lane[l] = l < rows.count
                            ? task.gradients->sh_rest.data() +
                                  static_cast<size_t>(rows.indices[l]) * stride
                            : unused;
  }
  StoreColors(d_rest, count, [&](int k, SimdNumber* d) HWY_ATTR {
    for (int c = 0; c < 3; ++c) d[c] = basis[k] * d_color[c];
  });
  if (3 * count == stride) return;
  for (size_t l = 0; l < rows.count; ++l) {
    std::fill(d_rest.of_lane[l] + 3 * count, d_rest.of_lane[l] + stride, 0.0f);
  }
}

// Adds the part of dL/dmean that comes from the viewing direction.
HWY_INLINE void BackwardDirection(int sh_degree,
                                  const Direction& direction,
                                  const SimdNumber basis_gradient[15],
                                  SimdNumber d_mean[3]) {
  const SimdNumber zero(0.0f);
  SimdNumber d[3] = {zero, zero, zero};
  BackwardShBasis(sh_degree,
                  direction.unit[0],
                  direction.unit[1],
                  direction.unit[2],
                  basis_gradient,
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
  SumLanes sums;
  GatherSums(task, first, group.count, &sums);
  const SimdNumber* moments = sums.moments;

  ProjectedGaussian<SimdNumber> projected;
  ProjectionTerms<SimdNumber> terms;
  // Returns true in every lane, as it did in the forward pass with the same
  // numbers.
  ProjectGaussian(camera, mean, log_scale, rotation, &projected, &terms);

  // ln(alpha) = ln(o) - (conic_xx e^2 + precision_y dy^2) / 2 with e = dx +
  // shear dy and (dx, dy) = pixel - mean; the moments are sums of dL/dln(alpha)
  // times powers of e and dy.
  ProjectedGradient<SimdNumber> gradient;
  gradient.mean[0] = projected.conic_xx * moments[1];
  gradient.mean[1] =
      projected.shear * gradient.mean[0] + projected.precision_y * moments[2];
  for (int k = 0; k < 3; ++k) gradient.moments[k] = moments[3 + k];
  gradient.depth = sums.depth_gradient;
  gradient.log_filter = model.antialiased ? moments[0] : SimdNumber(0.0f);
  LaneArray x = {}, y = {};
  ToArray(gradient.mean[0], &x);
  ToArray(gradient.mean[1], &y);
  for (size_t l = 0; l < group.count; ++l) {
    float* out = task.mean2d_gradients + 2 * (first + l);
    out[0] = x.values[l];
    out[1] = y.values[l];
  }

  // d ln(sigmoid(x)) / dx = 1 - sigmoid(x).
  LaneArray logits = {}, d_logit = {};
  for (size_t l = 0; l < group.count; ++l) {
    logits.values[l] = model.opacity_logits[group.indices[l]];
  }
  ToArray(moments[0] / (SimdNumber(1.0f) + exp(FromArray(logits))), &d_logit);
  for (size_t l = 0; l < group.count; ++l) {
    task.gradients->opacity_logits[rows.indices[l]] = d_logit.values[l];
  }

  const SimdNumber zero(0.0f);
  const SimdNumber* d_color = moments + kNumMoments;
  SimdNumber d_dc[3];
  for (int c = 0; c < 3; ++c) {
    d_dc[c] = SimdNumber(kShC0) * d_color[c];
  }
  StoreRows<3>(rows, d_dc, task.gradients->sh_dc.data());
  SimdNumber d_mean[3] = {zero, zero, zero};
  SimdNumber basis[15], basis_gradient[15];
  if (task.forward.sh_degree > 0) {
    const Direction direction = ViewDirection(mean, camera);
    EvaluateShBasis(task.forward.sh_degree,
                    direction.unit[0],
                    direction.unit[1],
                    direction.unit[2],
                    basis);
    BackwardRest(task, group, rows, d_color, basis, basis_gradient);
    BackwardDirection(
        task.forward.sh_degree, direction, basis_gradient, d_mean);
  } else if (model.sh_degree > 0) {
    BackwardRest(task, group, rows, d_color, basis, basis_gradient);
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
  const size_t num_lanes = hn::Lanes(Tag());
  for (size_t j = 0; j < task.count; j += num_lanes) {
    const size_t ahead = std::min(j + 2 * num_lanes, task.count);
    PrefetchRest(*task.forward.model,
                 task.visible + ahead,
                 std::min(num_lanes, task.count - ahead));
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
