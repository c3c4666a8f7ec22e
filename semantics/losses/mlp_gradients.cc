// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/mlp_gradients.h"

#include <algorithm>
#include <cmath>

#include "semantics/losses/matrix_products.h"

namespace freegs::semantics {
namespace {

constexpr int64_t kMlpRowGrain = 32;

// Calls body(k, column) for every value of a matrix of `cols` columns.
template <typename Body>
void ForEachValue(int64_t rows,
                  int64_t cols,
                  ThreadPool& pool,
                  const Body& body) {
  pool.ParallelFor(
      0, rows, kMlpRowGrain, [&](int64_t first, int64_t last, int) {
        for (int64_t row = first; row < last; ++row) {
          for (int64_t col = 0; col < cols; ++col) body(row * cols + col, col);
        }
      });
}

// Writes the statistics of `values`, S x H, into the batch.
void MeasureStatistics(const std::vector<float>& values,
                       int64_t cols,
                       ThreadPool& pool,
                       MlpBatch* batch) {
  const double scale =
      1.0 / static_cast<double>(std::max<int64_t>(1, batch->rows));
  batch->means = ColumnSums(
      batch->rows, cols, pool, [&](int64_t row, int64_t col) -> double {
        return values[row * cols + col];
      });
  for (double& mean : batch->means) mean *= scale;
  batch->variances = ColumnSums(
      batch->rows, cols, pool, [&](int64_t row, int64_t col) -> double {
        const double d = values[row * cols + col] - batch->means[col];
        return d * d;
      });
  batch->inv_deviations.resize(cols);
  for (int64_t col = 0; col < cols; ++col) {
    batch->variances[col] *= scale;
    batch->inv_deviations[col] =
        1 / std::sqrt(batch->variances[col] + MlpDecoder::kEpsilon);
  }
}

// Turns dL/dhidden into dL/d(W1 r), both S x H, and adds the derivatives of the
// normalisation's parameters. With y = scale x + shift, x normalised,
//   dL/dz = scale / deviation (g - mean(g) - x mean(g x)),  g = dL/dy.
void BackwardThroughNormalization(const MlpBatch& batch,
                                  std::span<const float> scales,
                                  ThreadPool& pool,
                                  const MlpParts<float>& parameter_gradients,
                                  std::vector<float>* gradients) {
  const auto cols = static_cast<int64_t>(scales.size());
  std::vector<float>& g = *gradients;
  ForEachValue(batch.rows, cols, pool, [&](int64_t k, int64_t) {
    if (!(batch.hidden[k] > 0)) g[k] = 0;
  });
  const std::vector<double> sums = ColumnSums(
      batch.rows, cols, pool, [&](int64_t row, int64_t col) -> double {
        return g[row * cols + col];
      });
  const std::vector<double> moments = ColumnSums(
      batch.rows, cols, pool, [&](int64_t row, int64_t col) -> double {
        const int64_t k = row * cols + col;
        return static_cast<double>(g[k]) * batch.normalized[k];
      });
  std::vector<float> factors(cols);
  std::vector<float> mean_g(cols);
  std::vector<float> mean_gx(cols);
  const auto rows = static_cast<double>(batch.rows);
  for (int64_t col = 0; col < cols; ++col) {
    parameter_gradients.shifts[col] += static_cast<float>(sums[col]);
    parameter_gradients.scales[col] += static_cast<float>(moments[col]);
    factors[col] = static_cast<float>(scales[col] * batch.inv_deviations[col]);
    mean_g[col] = static_cast<float>(sums[col] / rows);
    mean_gx[col] = static_cast<float>(moments[col] / rows);
  }
  ForEachValue(batch.rows, cols, pool, [&](int64_t k, int64_t col) {
    g[k] = factors[col] *
           (g[k] - mean_g[col] - batch.normalized[k] * mean_gx[col]);
  });
}

}  // namespace

bool MlpBatch::statistics_finite() const {
  const auto finite = [](double value) {
    return std::isfinite(static_cast<float>(value));
  };
  return std::all_of(means.begin(), means.end(), finite) &&
         std::all_of(variances.begin(), variances.end(), finite);
}

void MlpForward(const MlpDecoder& decoder,
                std::span<const float> latents,
                ThreadPool& pool,
                MlpBatch* batch,
                std::span<float> features) {
  const MlpShape& shape = decoder.shape;
  const MlpParts<const float> parts = decoder.parts();
  const int64_t cols = shape.hidden_dim;
  batch->rows = static_cast<int64_t>(latents.size()) / shape.latent_dim;
  batch->latents.assign(latents.begin(), latents.end());
  batch->normalized.resize(batch->rows * cols);
  batch->hidden.resize(batch->rows * cols);
  std::vector<float>& values = batch->normalized;  // Normalised below.
  ApplyLayer(AsRows(latents, shape.latent_dim),
             AsRows(parts.hidden_weights, shape.latent_dim),
             {},
             Activation::kNone,
             pool,
             AsRows(values, cols));
  MeasureStatistics(values, cols, pool, batch);
  ForEachValue(batch->rows, cols, pool, [&](int64_t k, int64_t col) {
    values[k] = static_cast<float>((values[k] - batch->means[col]) *
                                   batch->inv_deviations[col]);
    batch->hidden[k] =
        std::max(0.0f, parts.scales[col] * values[k] + parts.shifts[col]);
  });
  ApplyLayer(AsRows(batch->hidden, cols),
             AsRows(parts.output_weights, cols),
             parts.output_biases,
             Activation::kNone,
             pool,
             AsRows(features, shape.feature_dim));
}

void UpdateRunningStatistics(const MlpBatch& batch,
                             double momentum,
                             MlpDecoder* decoder) {
  if (batch.rows == 0) return;
  const auto rows = static_cast<double>(batch.rows);
  for (size_t h = 0; h < batch.means.size(); ++h) {
    float& mean = decoder->running_means[h];
    mean += static_cast<float>(momentum * (batch.means[h] - mean));
    if (batch.rows == 1) continue;
    float& variance = decoder->running_variances[h];
    const double unbiased = batch.variances[h] * rows / (rows - 1);
    variance += static_cast<float>(momentum * (unbiased - variance));
  }
}

void MlpBackward(const MlpDecoder& decoder,
                 const MlpBatch& batch,
                 std::span<const float> feature_gradients,
                 ThreadPool& pool,
                 std::span<float> parameter_gradients,
                 std::span<float> latent_gradients) {
  if (batch.rows == 0) return;
  const MlpShape& shape = decoder.shape;
  const MlpParts<const float> parts = decoder.parts();
  const MlpParts<float> gradients = PartsOf(shape, parameter_gradients);
  const int64_t channels = shape.feature_dim;
  const int64_t cols = shape.hidden_dim;
  const ConstRows output = AsRows(feature_gradients, channels);

  const std::vector<double> bias_gradients = ColumnSums(
      batch.rows, channels, pool, [&](int64_t row, int64_t col) -> double {
        return feature_gradients[row * channels + col];
      });
  for (int64_t c = 0; c < channels; ++c) {
    gradients.output_biases[c] += static_cast<float>(bias_gradients[c]);
  }
  AddTransposedProduct(output,
                       AsRows(batch.hidden, cols),
                       pool,
                       AsRows(gradients.output_weights, cols));

  std::vector<float> hidden(batch.rows * cols,
                            0.0f);  // dL/dhidden, then dL/d(W1 r).
  AddProduct(
      output, AsRows(parts.output_weights, cols), pool, AsRows(hidden, cols));
  BackwardThroughNormalization(batch, parts.scales, pool, gradients, &hidden);
  AddTransposedProduct(AsRows(hidden, cols),
                       AsRows(batch.latents, shape.latent_dim),
                       pool,
                       AsRows(gradients.hidden_weights, shape.latent_dim));
  AddProduct(AsRows(hidden, cols),
             AsRows(parts.hidden_weights, shape.latent_dim),
             pool,
             AsRows(latent_gradients, shape.latent_dim));
}

}  // namespace freegs::semantics
