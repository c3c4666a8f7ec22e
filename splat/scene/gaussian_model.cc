// SPDX-License-Identifier: BSD-3-Clause

#include "splat/scene/gaussian_model.h"

#include <algorithm>
#include <cmath>

namespace freegs::splat {
namespace {

std::vector<float> SelectRows(const std::vector<float>& array,
                              int stride,
                              std::span<const uint32_t> indices) {
  std::vector<float> kept(indices.size() * stride);
  for (size_t i = 0; i < indices.size(); ++i) {
    std::copy_n(array.begin() + static_cast<size_t>(indices[i]) * stride,
                stride,
                kept.begin() + i * stride);
  }
  return kept;
}

}  // namespace

std::vector<float>& ParameterArray(GaussianModel& model, Parameter parameter) {
  switch (parameter) {
    case Parameter::kMean:
      return model.means;
    case Parameter::kLogScale:
      return model.log_scales;
    case Parameter::kRotation:
      return model.rotations;
    case Parameter::kOpacityLogit:
      return model.opacity_logits;
    case Parameter::kShDc:
      return model.sh_dc;
    case Parameter::kShRest:
      break;
  }
  return model.sh_rest;
}

const std::vector<float>& ParameterArray(const GaussianModel& model,
                                         Parameter parameter) {
  return ParameterArray(const_cast<GaussianModel&>(model), parameter);
}

int ParameterStride(const GaussianModel& model, Parameter parameter) {
  switch (parameter) {
    case Parameter::kRotation:
      return 4;
    case Parameter::kOpacityLogit:
      return 1;
    case Parameter::kShRest:
      return model.sh_rest_stride();
    case Parameter::kMean:
    case Parameter::kLogScale:
    case Parameter::kShDc:
      break;
  }
  return 3;
}

double Opacity(const GaussianModel& model, size_t index) {
  return 1 / (1 + std::exp(-double{model.opacity_logits[index]}));
}

void GaussianModel::Resize(size_t count) {
  for (const Parameter parameter : kAllParameters) {
    const int stride = ParameterStride(*this, parameter);
    ParameterArray(*this, parameter).resize(count * stride);
  }
}

void GaussianModel::Select(std::span<const uint32_t> indices) {
  for (const Parameter parameter : kAllParameters) {
    std::vector<float>& array = ParameterArray(*this, parameter);
    array = SelectRows(array, ParameterStride(*this, parameter), indices);
  }
}

GaussianModel GaussianModel::Selected(std::span<const uint32_t> indices) const {
  GaussianModel selected;
  selected.sh_degree = sh_degree;
  selected.antialiased = antialiased;
  for (const Parameter parameter : kAllParameters) {
    ParameterArray(selected, parameter) =
        SelectRows(ParameterArray(*this, parameter),
                   ParameterStride(*this, parameter),
                   indices);
  }
  return selected;
}

void GaussianModel::AppendFrom(const GaussianModel& other, size_t index) {
  for (const Parameter parameter : kAllParameters) {
    const int stride = ParameterStride(*this, parameter);
    const std::vector<float>& from = ParameterArray(other, parameter);
    std::vector<float>& to = ParameterArray(*this, parameter);
    const size_t end = to.size();
    to.resize(end + stride);
    std::copy_n(from.begin() + index * stride, stride, to.begin() + end);
  }
}

void GaussianModel::SetShDegree(int degree) {
  const size_t count = size();
  const int old_stride = sh_rest_stride();
  sh_degree = degree;
  const int new_stride = sh_rest_stride();
  std::vector<float> rest(count * new_stride, 0.0f);
  for (size_t i = 0; i < count; ++i) {
    std::copy_n(sh_rest.begin() + i * old_stride,
                std::min(old_stride, new_stride),
                rest.begin() + i * new_stride);
  }
  sh_rest = std::move(rest);
}

bool GaussianModel::AllFinite() const {
  return std::all_of(
      kAllParameters.begin(), kAllParameters.end(), [this](Parameter p) {
        const std::vector<float>& array = ParameterArray(*this, p);
        return std::all_of(array.begin(), array.end(), [](float v) {
          return std::isfinite(v);
        });
      });
}

}  // namespace freegs::splat
