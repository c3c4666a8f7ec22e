// SPDX-License-Identifier: BSD-3-Clause

#include "splat/scene/splat_format.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "core/io/byte_stream.h"
#include "core/io/files.h"

namespace freegs::splat {
namespace {

constexpr size_t kRecordBytes = 32;
constexpr float kMaxStoredLogScale = 88;  // Its exponential is a finite float.

double LogOpacity(const GaussianModel& model, size_t i) {
  const double logit = model.opacity_logits[i];
  return std::min(logit, 0.0) - std::log1p(std::exp(-std::abs(logit)));
}

uint8_t ToByte(double value) {
  return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

void PutRecord(const GaussianModel& model, size_t i, ByteWriter* writer) {
  std::array<float, 6> geometry;
  std::array<uint8_t, 8> bytes;
  double norm = 0;
  for (int k = 0; k < 4; ++k) {
    norm += std::pow(static_cast<double>(model.rotations[4 * i + k]), 2);
  }
  norm = std::sqrt(norm);
  for (int k = 0; k < 3; ++k) {
    geometry[k] = model.means[3 * i + k];
    geometry[3 + k] =
        std::exp(std::min(model.log_scales[3 * i + k], kMaxStoredLogScale));
    bytes[k] = ToByte(255.0 * (0.5 + kShC0 * model.sh_dc[3 * i + k]));
  }
  bytes[3] = ToByte(255.0 * Opacity(model, i));
  for (int k = 0; k < 4; ++k) {
    const double identity = k == 0 ? 1.0 : 0.0;
    const double c = norm > 0 ? model.rotations[4 * i + k] / norm : identity;
    bytes[4 + k] = ToByte(c * 128.0 + 128.0);
  }
  writer->PutArray(geometry);
  writer->PutArray(bytes);
}

}  // namespace

std::string SerializeSplat(const GaussianModel& model) {
  std::vector<double> importance(model.size());
  for (size_t i = 0; i < model.size(); ++i) {
    const double log_volume = static_cast<double>(model.log_scales[3 * i]) +
                              model.log_scales[3 * i + 1] +
                              model.log_scales[3 * i + 2];
    importance[i] = log_volume + LogOpacity(model, i);
  }
  std::vector<uint32_t> order(model.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return importance[a] > importance[b];
  });
  ByteWriter writer;
  writer.Reserve(model.size() * kRecordBytes);
  for (const uint32_t i : order) PutRecord(model, i, &writer);
  return std::move(writer).content();
}

Status WriteSplat(const std::filesystem::path& path,
                  const GaussianModel& model) {
  return WriteFileAtomic(path, SerializeSplat(model));
}

}  // namespace freegs::splat
