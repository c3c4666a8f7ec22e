// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip_export/clip_networks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

namespace freegs::semantics {
namespace {

using Shape = OnnxGraph::Shape;

// The layer norm before a linear layer, folded into it.
void FoldNorm(const LayerNorm& norm, LinearLayer* linear) {
  const auto columns = static_cast<size_t>(linear->columns);
  for (size_t i = 0; i < static_cast<size_t>(linear->rows); ++i) {
    float* row = linear->weight.data() + i * columns;
    double sum = 0;
    for (size_t j = 0; j < columns; ++j) {
      sum += double{row[j]} * norm.offset[j];
      row[j] = static_cast<float>(double{row[j]} * norm.gain[j]);
    }
    linear->bias[i] = static_cast<float>(linear->bias[i] + sum);
  }
}

// Puts blocks of one tower into a graph. Values are B x n x width between the
// blocks, and B x width x n x 1 where convolutions need that.
class TowerBuilder {
 public:
  TowerBuilder(const ClipCheckpoint& checkpoint,
               Tower tower,
               int count,
               OnnxGraph* graph)
      : checkpoint_(checkpoint),
        tower_(tower),
        shape_(tower == Tower::kVisual ? checkpoint.architecture().visual
                                       : checkpoint.architecture().text),
        count_(count),
        graph_(*graph) {}

  OnnxValue ToColumns(const OnnxValue& x, int count) {
    return graph_.Reshape(graph_.Transpose(x, {0, 2, 1}),
                          {-1, shape_.width, count, 1});
  }

  OnnxValue ToRows(const OnnxValue& x, int width) {
    return graph_.Transpose(graph_.Reshape(x, {-1, width, count_}), {0, 2, 1});
  }

  OnnxValue Convolve(const OnnxValue& x, LinearLayer layer) {
    return graph_.Convolution(x,
                              {{layer.rows, layer.columns, 1, 1},
                               std::move(layer.weight),
                               std::move(layer.bias)});
  }

  OnnxValue Normalize(const OnnxValue& x, int count) {
    return ToColumns(graph_.InstanceNorm(x, count, shape_.epsilon), count);
  }

  // A residual attention block. mask: of the scores, or empty.
  StatusOr<OnnxValue> Block(const OnnxValue& x,
                            int layer,
                            const OnnxValue& mask) {
    FREEGS_ASSIGN_OR_RETURN(LinearLayer q, Attention(layer, kQuery));
    FREEGS_ASSIGN_OR_RETURN(LinearLayer k, Attention(layer, kKey));
    FREEGS_ASSIGN_OR_RETURN(LinearLayer v, Attention(layer, kValue));
    const int head_width = shape_.width / shape_.heads;
    const Shape heads = {-1, shape_.heads, head_width, count_};
    const Shape turned = {0, 1, 3, 2};
    const OnnxValue y = Normalize(x, count_);
    const OnnxValue query = graph_.Transpose(
        graph_.Reshape(Convolve(y, std::move(q)), heads), turned);
    const OnnxValue key = graph_.Reshape(Convolve(y, std::move(k)), heads);
    const OnnxValue value = graph_.Transpose(
        graph_.Reshape(Convolve(y, std::move(v)), heads), turned);
    OnnxValue scores = graph_.Node("MatMul", {query, key});
    if (!mask.empty()) scores = graph_.Node("Add", {scores, mask});
    const OnnxValue mixed =
        graph_.Node("MatMul", {graph_.SoftmaxOfLast(scores), value});
    FREEGS_ASSIGN_OR_RETURN(
        LinearLayer out,
        checkpoint_.Linear(tower_, layer, ClipCheckpoint::kAttentionOut));
    const OnnxValue columns = graph_.Reshape(graph_.Transpose(mixed, turned),
                                             {-1, shape_.width, count_, 1});
    const OnnxValue between = graph_.Node(
        "Add", {x, ToRows(Convolve(columns, std::move(out)), shape_.width)});
    FREEGS_ASSIGN_OR_RETURN(const OnnxValue mlp, Mlp(between, layer));
    return graph_.Node("Add", {between, mlp});
  }

  // A block by its value projection only.
  StatusOr<OnnxValue> ValueBlock(const OnnxValue& x, int layer) {
    FREEGS_ASSIGN_OR_RETURN(LinearLayer v, Attention(layer, kValue));
    FREEGS_ASSIGN_OR_RETURN(
        LinearLayer out,
        checkpoint_.Linear(tower_, layer, ClipCheckpoint::kAttentionOut));
    const OnnxValue values = Convolve(Normalize(x, count_), std::move(v));
    return ToRows(Convolve(values, std::move(out)), shape_.width);
  }

  // The last norm and the projection of `count` positions, B x D x count x 1.
  StatusOr<OnnxValue> Project(const OnnxValue& x, int count) {
    FREEGS_ASSIGN_OR_RETURN(LinearLayer layer, checkpoint_.Projection(tower_));
    FREEGS_ASSIGN_OR_RETURN(const LayerNorm norm, checkpoint_.LastNorm(tower_));
    FoldNorm(norm, &layer);
    return Convolve(Normalize(x, count), std::move(layer));
  }

 private:
  static constexpr auto kQuery = ClipCheckpoint::kQuery;
  static constexpr auto kKey = ClipCheckpoint::kKey;
  static constexpr auto kValue = ClipCheckpoint::kValue;

  StatusOr<LinearLayer> Attention(int layer,
                                  ClipCheckpoint::BlockLinear part) const {
    FREEGS_ASSIGN_OR_RETURN(LinearLayer linear,
                            checkpoint_.Linear(tower_, layer, part));
    if (part == kQuery) {
      const auto scale = static_cast<float>(
          1 / std::sqrt(static_cast<double>(shape_.width / shape_.heads)));
      for (float& value : linear.weight) value *= scale;
      for (float& value : linear.bias) value *= scale;
    }
    FREEGS_ASSIGN_OR_RETURN(
        const LayerNorm norm,
        checkpoint_.Norm(tower_, layer, ClipCheckpoint::kBeforeAttention));
    FoldNorm(norm, &linear);
    return linear;
  }

  StatusOr<OnnxValue> Mlp(const OnnxValue& x, int layer) {
    FREEGS_ASSIGN_OR_RETURN(
        LinearLayer in,
        checkpoint_.Linear(tower_, layer, ClipCheckpoint::kMlpIn));
    FREEGS_ASSIGN_OR_RETURN(
        LinearLayer out,
        checkpoint_.Linear(tower_, layer, ClipCheckpoint::kMlpOut));
    FREEGS_ASSIGN_OR_RETURN(
        const LayerNorm norm,
        checkpoint_.Norm(tower_, layer, ClipCheckpoint::kBeforeMlp));
    FoldNorm(norm, &in);
    const OnnxValue y = Activate(Convolve(Normalize(x, count_), std::move(in)));
    return ToRows(Convolve(y, std::move(out)), shape_.width);
  }

  OnnxValue Activate(const OnnxValue& x) {
    if (shape_.activation == MlpActivation::kQuickGelu) {
      const OnnxValue scaled = graph_.Node("Mul", {x, graph_.Number(1.702f)});
      return graph_.Node("Mul", {x, graph_.Node("Sigmoid", {scaled})});
    }
    const auto root = static_cast<float>(std::sqrt(2.0));
    const OnnxValue scaled = graph_.Node("Div", {x, graph_.Number(root)});
    const OnnxValue erf = graph_.Node("Erf", {scaled});
    const OnnxValue sum = graph_.Node("Add", {erf, graph_.Number(1)});
    const OnnxValue product = graph_.Node("Mul", {x, sum});
    return graph_.Node("Mul", {product, graph_.Number(0.5f)});
  }

  const ClipCheckpoint& checkpoint_;
  const Tower tower_;
  const TransformerShape& shape_;
  const int count_;  // Positions.
  OnnxGraph& graph_;
};

// The weights of four neighbours of a place that lies `t` behind the second.
std::array<double, 4> CubicWeights(double t) {
  constexpr double a = -0.75;
  const auto near = [](double x) {
    return ((a + 2) * x - (a + 3)) * x * x + 1;
  };
  const auto far = [](double x) {
    return ((a * x - 5 * a) * x + 8 * a) * x - 4 * a;
  };
  return {far(t + 1), near(t), near(1 - t), far(2 - t)};
}

}  // namespace

std::vector<float> ResizePositions(const std::vector<float>& positions,
                                   int width,
                                   int old_grid,
                                   int new_grid) {
  if (old_grid == new_grid) return positions;
  struct Taps {
    std::array<int, 4> cells;
    std::array<double, 4> weights;
  };
  std::vector<Taps> taps(static_cast<size_t>(new_grid));
  const double scale = static_cast<double>(old_grid) / new_grid;
  for (int i = 0; i < new_grid; ++i) {
    const double place = (i + 0.5) * scale - 0.5;
    const auto cell = static_cast<int>(std::floor(place));
    taps[i].weights = CubicWeights(place - cell);
    for (int k = 0; k < 4; ++k) {
      taps[i].cells[k] = std::clamp(cell - 1 + k, 0, old_grid - 1);
    }
  }
  const auto size = static_cast<size_t>(width);
  std::vector<float> result((static_cast<size_t>(new_grid) * new_grid + 1) *
                            size);
  std::copy_n(positions.begin(), size, result.begin());
  std::vector<double> sum(size);
  float* out = result.data() + size;
  for (const Taps& y : taps) {
    for (const Taps& x : taps) {
      std::fill(sum.begin(), sum.end(), 0.0);
      for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
          const double weight = y.weights[i] * x.weights[j];
          const size_t cell =
              1 + static_cast<size_t>(y.cells[i]) * old_grid + x.cells[j];
          const float* vector = positions.data() + cell * size;
          for (size_t k = 0; k < size; ++k) sum[k] += weight * vector[k];
        }
      }
      for (const double value : sum) *out++ = static_cast<float>(value);
    }
  }
  return result;
}

StatusOr<OnnxGraph> ImageNetwork(const ClipCheckpoint& checkpoint,
                                 int image_size,
                                 bool dense) {
  const ClipArchitecture& a = checkpoint.architecture();
  const int width = a.visual.width;
  const int grid = image_size / a.patch;
  const int cells = grid * grid;
  if (int64_t{cells} * width > (int64_t{1} << 28)) {
    return MissingDependencyError(checkpoint.path().string() + ": images of " +
                                  std::to_string(image_size) +
                                  " pixels have too many places for it");
  }
  FREEGS_ASSIGN_OR_RETURN(std::vector<float> patches, checkpoint.Patches());
  FREEGS_ASSIGN_OR_RETURN(const std::vector<float> positions,
                          checkpoint.Positions(Tower::kVisual));
  FREEGS_ASSIGN_OR_RETURN(const std::vector<float> token,
                          checkpoint.ClassToken());
  FREEGS_ASSIGN_OR_RETURN(LayerNorm norm, checkpoint.FirstNorm());
  std::vector<float> table =
      ResizePositions(positions, width, a.image_size / a.patch, grid);
  for (size_t k = 0; k < token.size(); ++k) table[k] += token[k];

  OnnxGraph graph;
  TowerBuilder tower(checkpoint, Tower::kVisual, cells + 1, &graph);
  OnnxValue x = graph.Input({1, 3, image_size, image_size});
  x = graph.Convolution(x,
                        {{width, 3, a.patch, a.patch}, std::move(patches), {}});
  x = graph.Reshape(x, {-1, width, cells});
  // Makes the place of the class token out of another one, because OpenCV has
  // no constants with a batch.
  const OnnxValue place =
      graph.Node("Mul", {graph.Slice(x, 2, 0, 1), graph.Number(0)});
  x = graph.Transpose(graph.Concat({place, x}, 2), {0, 2, 1});
  x = graph.Node("Add", {x, graph.Weights({cells + 1, width}, table)});
  x = graph.Convolution(
      tower.Normalize(x, cells + 1),
      {{width, 1, 1, 1}, std::move(norm.gain), std::move(norm.offset), width});
  x = tower.ToRows(x, width);
  for (int i = 0; i < a.visual.layers; ++i) {
    const bool value_only = dense && i + 1 == a.visual.layers;
    FREEGS_ASSIGN_OR_RETURN(
        x, value_only ? tower.ValueBlock(x, i) : tower.Block(x, i, ""));
  }
  x = dense ? graph.Slice(x, 1, 1, std::numeric_limits<int64_t>::max())
            : graph.Slice(x, 1, 0, 1);
  FREEGS_ASSIGN_OR_RETURN(x, tower.Project(x, dense ? cells : 1));
  const Shape shape =
      dense ? Shape{1, a.embedding_dim, grid, grid} : Shape{1, a.embedding_dim};
  Shape any_batch = shape;
  any_batch[0] = -1;
  graph.Output(graph.Reshape(x, any_batch), shape);
  return graph;
}

StatusOr<OnnxGraph> TextNetwork(const ClipCheckpoint& checkpoint) {
  const ClipArchitecture& a = checkpoint.architecture();
  const int count = a.text.positions;
  const auto size = static_cast<size_t>(count);
  FREEGS_ASSIGN_OR_RETURN(const std::vector<float> positions,
                          checkpoint.Positions(Tower::kText));
  // No position sees what follows it.
  std::vector<float> hidden(size * size, 0.0f);
  for (size_t i = 0; i < size; ++i) {
    std::fill(hidden.begin() + i * size + i + 1,
              hidden.begin() + (i + 1) * size,
              -std::numeric_limits<float>::infinity());
  }
  OnnxGraph graph;
  TowerBuilder tower(checkpoint, Tower::kText, count, &graph);
  OnnxValue x = graph.Input({1, count, a.text.width});
  x = graph.Node("Add", {x, graph.Weights({count, a.text.width}, positions)});
  const OnnxValue mask = graph.Weights({count, count}, hidden);
  for (int i = 0; i < a.text.layers; ++i) {
    FREEGS_ASSIGN_OR_RETURN(x, tower.Block(x, i, mask));
  }
  FREEGS_ASSIGN_OR_RETURN(x, tower.Project(x, count));
  graph.Output(tower.ToRows(x, a.embedding_dim), {1, count, a.embedding_dim});
  return graph;
}

}  // namespace freegs::semantics
