// SPDX-License-Identifier: BSD-3-Clause
// An encoder that needs no model: it sees colours and nothing else.

#ifndef FREEGS_TESTS_SEMANTICS_CLIP_COLOR_ENCODER_H_
#define FREEGS_TESTS_SEMANTICS_CLIP_COLOR_ENCODER_H_

#include <array>
#include <atomic>
#include <cmath>
#include <string>
#include <vector>

#include "core/io/image_io.h"
#include "semantics/clip/clip_encoder.h"

namespace freegs::semantics {

// Eight numbers for a colour: nearer colours have higher cosines. Grey, which
// crops are padded with, is left out of the mean of an image.
class ColorEncoder : public ClipEncoder {
 public:
  static constexpr int kGrid = 16;

  int embedding_dim() const override { return 8; }
  const std::string& model_hash() const override { return hash_; }
  std::vector<int> dense_sizes() const override { return {kGrid}; }

  StatusOr<std::vector<float>> EncodeImage(const ImageU8& image) override {
    std::array<double, 3> sum = {};
    double count = 0;
    for (size_t i = 0; i < image.num_pixels(); ++i) {
      const uint8_t* rgb = image.data() + 3 * i;
      if (rgb[0] == 123 && rgb[1] == 117 && rgb[2] == 104) continue;
      for (int c = 0; c < 3; ++c) sum[c] += rgb[c] / 255.0;
      ++count;
    }
    for (double& x : sum) x /= std::max(1.0, count);
    return Embed(sum);
  }

  StatusOr<ImageF> EncodeDense(const ImageU8& image, int) override {
    ++num_dense;
    const ImageU8 small = Resize(image, kGrid, kGrid);
    ImageF features(kGrid, kGrid, 8);
    for (size_t i = 0; i < small.num_pixels(); ++i) {
      const uint8_t* rgb = small.data() + 3 * i;
      const std::vector<float> vector =
          Embed({rgb[0] / 255.0, rgb[1] / 255.0, rgb[2] / 255.0});
      // Twice as long: lengths of places are not to matter.
      for (int c = 0; c < 8; ++c) features.data()[8 * i + c] = 2 * vector[c];
    }
    return features;
  }

  int upsampled_size() const override { return 0; }
  StatusOr<ImageF> Upsample(const ImageF&, const ImageU8&) override {
    return InvalidArgumentError("no upsampler");
  }
  // Colours have names; all other words are grey.
  StatusOr<TextEmbedding> EncodeText(const std::string& text) override {
    if (text == "red") return TextEmbedding{.values = Embed({0.8, 0.1, 0.1})};
    if (text == "green") return TextEmbedding{.values = Embed({0.1, 0.7, 0.1})};
    if (text == "blue") return TextEmbedding{.values = Embed({0.1, 0.2, 0.8})};
    return TextEmbedding{.values = Embed({0.5, 0.5, 0.5})};
  }

  static std::vector<float> Embed(const std::array<double, 3>& rgb) {
    std::vector<float> vector;
    double square = 0;
    for (const double x : rgb) {
      for (const double value : {x - 0.5, 0.5 - x}) {
        vector.push_back(static_cast<float>(std::max(0.0, value)));
      }
    }
    vector.push_back(0.1f);
    vector.push_back(static_cast<float>(rgb[0] * 0.2));
    for (const float x : vector) square += double{x} * x;
    for (float& x : vector) x = static_cast<float>(x / std::sqrt(square));
    return vector;
  }

  std::atomic<int> num_dense = 0;

 private:
  std::string hash_ = "colours";
};

}  // namespace freegs::semantics

#endif  // FREEGS_TESTS_SEMANTICS_CLIP_COLOR_ENCODER_H_
