// SPDX-License-Identifier: BSD-3-Clause
// CLIP as its paper has it, in double precision, one loop after another.

#ifndef FREEGS_TESTS_SEMANTICS_CLIP_EXPORT_REFERENCE_CLIP_H_
#define FREEGS_TESTS_SEMANTICS_CLIP_EXPORT_REFERENCE_CLIP_H_

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "tests/semantics/clip_export/random_clip.h"

namespace freegs::semantics {

class ReferenceClip {
 public:
  using Matrix =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  ReferenceClip(const TestTensors& tensors, bool quick_gelu)
      : tensors_(tensors), quick_gelu_(quick_gelu) {}

  // patches: a row of colours for each patch, channel by channel; positions:
  // one more row than patches. Returns the image's vector as one row, or if
  // dense a row for each patch.
  Matrix Image(const Matrix& patches,
               const Matrix& positions,
               bool dense) const {
    const TestTensor& kernel = tensors_.at("visual.conv1.weight");
    Matrix x(patches.rows() + 1, RandomClip::kWidth);
    x.row(0) = Get("visual.class_embedding").transpose();
    x.bottomRows(patches.rows()) =
        patches * AsMatrix(kernel, kernel.shape[0]).transpose();
    x = Norm(x + positions, "visual.ln_pre");
    for (int i = 0; i < RandomClip::kLayers; ++i) {
      const std::string block =
          "visual.transformer.resblocks." + std::to_string(i) + ".";
      x = dense && i + 1 == RandomClip::kLayers
              ? ValuesOnly(x, block)
              : Block(x, block, RandomClip::kHeads, false);
    }
    x = Norm(x, "visual.ln_post") * Get("visual.proj");
    return dense ? Matrix(x.bottomRows(patches.rows())) : Matrix(x.topRows(1));
  }

  // tokens: a row for each position. Returns the vector of the last.
  Matrix Text(const Matrix& tokens) const {
    Matrix x = tokens + Get("positional_embedding").topRows(tokens.rows());
    for (int i = 0; i < RandomClip::kTextLayers; ++i) {
      x = Block(x,
                "transformer.resblocks." + std::to_string(i) + ".",
                RandomClip::kTextHeads,
                true);
    }
    return Norm(x, "ln_final").bottomRows(1) * Get("text_projection");
  }

  Matrix Get(const std::string& name) const {
    const TestTensor& tensor = tensors_.at(name);
    return AsMatrix(tensor, tensor.shape[0]);
  }

 private:
  static Matrix AsMatrix(const TestTensor& tensor, int64_t rows) {
    const auto count = static_cast<int64_t>(tensor.values.size());
    return Eigen::
        Map<const Eigen::
                Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
               tensor.values.data(), rows, count / rows)
            .cast<double>();
  }

  Matrix Norm(Matrix x, const std::string& name) const {
    const Matrix gain = Get(name + ".weight");
    const Matrix offset = Get(name + ".bias");
    for (int i = 0; i < x.rows(); ++i) {
      const double mean = x.row(i).mean();
      x.row(i).array() -= mean;
      const double variance = x.row(i).squaredNorm() / x.cols();
      x.row(i) /= std::sqrt(variance + 1e-5);
      x.row(i) = x.row(i).cwiseProduct(gain.transpose()) + offset.transpose();
    }
    return x;
  }

  Matrix Linear(const Matrix& x,
                const Matrix& weight,
                const Matrix& bias) const {
    return (x * weight.transpose()).rowwise() + bias.col(0).transpose();
  }

  Matrix Block(const Matrix& x,
               const std::string& block,
               int heads,
               bool causal) const {
    const Matrix y = Linear(Norm(x, block + "ln_1"),
                            Get(block + "attn.in_proj_weight"),
                            Get(block + "attn.in_proj_bias"));
    const auto width = x.cols();
    const auto head = width / heads;
    Matrix mixed(x.rows(), width);
    for (int h = 0; h < heads; ++h) {
      const Matrix q = y.middleCols(h * head, head);
      const Matrix k = y.middleCols(width + h * head, head);
      const Matrix v = y.middleCols(2 * width + h * head, head);
      Matrix scores = q * k.transpose() / std::sqrt(static_cast<double>(head));
      for (int i = 0; i < scores.rows(); ++i) {
        for (int j = i + 1; causal && j < scores.cols(); ++j) {
          scores(i, j) = -1e30;
        }
        scores.row(i) =
            (scores.row(i).array() - scores.row(i).maxCoeff()).exp();
        scores.row(i) /= scores.row(i).sum();
      }
      mixed.middleCols(h * head, head) = scores * v;
    }
    const Matrix between = x + Linear(mixed,
                                      Get(block + "attn.out_proj.weight"),
                                      Get(block + "attn.out_proj.bias"));
    Matrix z = Linear(Norm(between, block + "ln_2"),
                      Get(block + "mlp.c_fc.weight"),
                      Get(block + "mlp.c_fc.bias"));
    z = z.unaryExpr([this](double value) {
      return quick_gelu_ ? value / (1 + std::exp(-1.702 * value))
                         : value * 0.5 * (1 + std::erf(value / std::sqrt(2.0)));
    });
    return between + Linear(z,
                            Get(block + "mlp.c_proj.weight"),
                            Get(block + "mlp.c_proj.bias"));
  }

  // MaskCLIP's last block.
  Matrix ValuesOnly(const Matrix& x, const std::string& block) const {
    const auto width = x.cols();
    const Matrix values =
        Linear(Norm(x, block + "ln_1"),
               Get(block + "attn.in_proj_weight").bottomRows(width),
               Get(block + "attn.in_proj_bias").bottomRows(width));
    return Linear(values,
                  Get(block + "attn.out_proj.weight"),
                  Get(block + "attn.out_proj.bias"));
  }

  const TestTensors& tensors_;
  const bool quick_gelu_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_TESTS_SEMANTICS_CLIP_EXPORT_REFERENCE_CLIP_H_
