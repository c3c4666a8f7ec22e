// SPDX-License-Identifier: BSD-3-Clause
// A tiny CLIP of random numbers, and its files in the layouts of Hugging Face
// and of OpenCLIP.

#ifndef FREEGS_TESTS_SEMANTICS_CLIP_EXPORT_RANDOM_CLIP_H_
#define FREEGS_TESTS_SEMANTICS_CLIP_EXPORT_RANDOM_CLIP_H_

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/random.h"
#include "tests/temporary_folder.h"

namespace freegs::semantics {

struct TestTensor {
  std::vector<int64_t> shape;
  std::vector<float> values;
};

using TestTensors = std::map<std::string, TestTensor>;

// The bytes of a safetensors file with this header and these numbers.
inline std::string SafetensorsBytes(const std::string& header,
                                    const std::string& data) {
  const uint64_t length = header.size();
  std::string bytes(reinterpret_cast<const char*>(&length), sizeof(length));
  return bytes + header + data;
}

inline std::string SafetensorsBytes(const TestTensors& tensors) {
  nlohmann::json header = {{"__metadata__", {{"format", "pt"}}}};
  std::string data;
  for (const auto& [name, tensor] : tensors) {
    const size_t bytes = tensor.values.size() * sizeof(float);
    header[name] = {{"dtype", "F32"},
                    {"shape", tensor.shape},
                    {"data_offsets", {data.size(), data.size() + bytes}}};
    data.append(reinterpret_cast<const char*>(tensor.values.data()), bytes);
  }
  return SafetensorsBytes(header.dump(), data);
}

// 16 pixels in patches of 8, 2 layers of 2 heads of 8 numbers; texts of at most
// 7 tokens, 1 layer of 3 heads of 4 numbers; vectors of 8 numbers.
class RandomClip {
 public:
  static constexpr int kImageSize = 16;
  static constexpr int kPatch = 8;
  static constexpr int kWidth = 16;
  static constexpr int kLayers = 2;
  static constexpr int kHeads = 2;
  static constexpr int kTextWidth = 12;
  static constexpr int kTextLayers = 1;
  static constexpr int kTextHeads = 3;
  static constexpr int kContext = 7;
  static constexpr int kVocabulary = 516;
  static constexpr int kDim = 8;

  RandomClip() {
    Draw("visual.conv1.weight", {kWidth, 3, kPatch, kPatch}, 0.1);
    Draw("visual.class_embedding", {kWidth}, 0.5);
    Draw("visual.positional_embedding", {5, kWidth}, 0.5);
    DrawNorm("visual.ln_pre", kWidth);
    DrawBlocks("visual.transformer", kWidth, kLayers);
    DrawNorm("visual.ln_post", kWidth);
    Draw("visual.proj", {kWidth, kDim}, 0.3);
    Draw("token_embedding.weight", {kVocabulary, kTextWidth}, 0.5);
    Draw("positional_embedding", {kContext, kTextWidth}, 0.2);
    DrawBlocks("transformer", kTextWidth, kTextLayers);
    DrawNorm("ln_final", kTextWidth);
    Draw("text_projection", {kTextWidth, kDim}, 0.3);
    Draw("logit_scale", {}, 1);
  }

  // Under OpenCLIP's names.
  const TestTensors& tensors() const { return tensors_; }

  // Under those that Hugging Face's transformers gives them.
  TestTensors HuggingFaceTensors() const {
    TestTensors result;
    for (const auto& [name, tensor] : tensors_) {
      const size_t joint = name.find("attn.in_proj_");
      if (joint != std::string::npos) {
        const std::string kind = name.substr(joint + 13);
        const size_t third = tensor.values.size() / 3;
        for (int i = 0; i < 3; ++i) {
          TestTensor part = tensor;
          part.shape[0] /= 3;
          part.values.assign(tensor.values.begin() + i * third,
                             tensor.values.begin() + (i + 1) * third);
          result[Renamed(name.substr(0, joint)) + "self_attn." + "qkv"[i] +
                 "_proj." + kind] = part;
        }
      } else if (name == "visual.proj" || name == "text_projection") {
        result[Renamed(name)] = Transposed(tensor);
      } else {
        result[Renamed(name)] = tensor;
      }
    }
    return result;
  }

  static nlohmann::json HuggingFaceConfig(const std::string& activation) {
    return {{"model_type", "clip"},
            {"vision_config",
             {{"num_attention_heads", kHeads},
              {"hidden_act", activation},
              {"patch_size", kPatch}}},
            {"text_config",
             {{"num_attention_heads", kTextHeads},
              {"hidden_act", activation},
              {"num_hidden_layers", kTextLayers}}}};
  }

  static nlohmann::json OpenClipConfig(const std::string& activation) {
    return {{"model_cfg",
             {{"embed_dim", kDim},
              {"quick_gelu", activation == "quick_gelu"},
              {"vision_cfg", {{"head_width", kWidth / kHeads}}},
              {"text_cfg", {{"heads", kTextHeads}}}}}};
  }

  void WriteHuggingFace(const std::filesystem::path& folder,
                        const std::string& activation) const {
    WriteText(folder / "model.safetensors",
              SafetensorsBytes(HuggingFaceTensors()));
    WriteText(folder / "config.json", HuggingFaceConfig(activation).dump());
    WriteText(folder / "merges.txt", kMerges);
  }

  void WriteOpenClip(const std::filesystem::path& folder,
                     const std::string& activation) const {
    WriteText(folder / "open_clip_model.safetensors",
              SafetensorsBytes(tensors_));
    WriteText(folder / "open_clip_config.json",
              OpenClipConfig(activation).dump());
    WriteText(folder / "merges.txt", kMerges);
  }

  static constexpr char kMerges[] = "#version: 0.2\nr e\nre d</w>\n";

 private:
  void Draw(const std::string& name,
            const std::vector<int64_t>& shape,
            double deviation,
            double mean = 0) {
    size_t count = 1;
    for (const int64_t side : shape) count *= static_cast<size_t>(side);
    TestTensor& tensor = tensors_[name];
    tensor.shape = shape;
    while (tensor.values.size() < count) {
      tensor.values.push_back(
          static_cast<float>(mean + deviation * random_.Normal()));
    }
  }

  void DrawNorm(const std::string& name, int width) {
    Draw(name + ".weight", {width}, 0.2, 1);
    Draw(name + ".bias", {width}, 0.1);
  }

  void DrawBlocks(const std::string& prefix, int width, int layers) {
    for (int i = 0; i < layers; ++i) {
      const std::string block = prefix + ".resblocks." + std::to_string(i);
      const double scale = 1 / std::sqrt(width);
      DrawNorm(block + ".ln_1", width);
      DrawNorm(block + ".ln_2", width);
      Draw(block + ".attn.in_proj_weight", {3 * width, width}, 1.5 * scale);
      Draw(block + ".attn.in_proj_bias", {3 * width}, 0.1);
      Draw(block + ".attn.out_proj.weight", {width, width}, scale);
      Draw(block + ".attn.out_proj.bias", {width}, 0.1);
      Draw(block + ".mlp.c_fc.weight", {4 * width, width}, scale);
      Draw(block + ".mlp.c_fc.bias", {4 * width}, 0.1);
      Draw(block + ".mlp.c_proj.weight", {width, 4 * width}, scale / 2);
      Draw(block + ".mlp.c_proj.bias", {width}, 0.1);
    }
  }

  static TestTensor Transposed(const TestTensor& tensor) {
    const auto rows = static_cast<size_t>(tensor.shape[0]);
    const auto columns = static_cast<size_t>(tensor.shape[1]);
    TestTensor result = {{tensor.shape[1], tensor.shape[0]}, tensor.values};
    for (size_t i = 0; i < rows; ++i) {
      for (size_t j = 0; j < columns; ++j) {
        result.values[j * rows + i] = tensor.values[i * columns + j];
      }
    }
    return result;
  }

  static std::string Renamed(std::string name) {
    static const std::pair<const char*, const char*> kNames[] = {
        {"visual.conv1", "vision_model.embeddings.patch_embedding"},
        {"visual.class_embedding", "vision_model.embeddings.class_embedding"},
        {"visual.positional_embedding",
         "vision_model.embeddings.position_embedding.weight"},
        {"visual.ln_pre", "vision_model.pre_layrnorm"},
        {"visual.ln_post", "vision_model.post_layernorm"},
        {"visual.proj", "visual_projection.weight"},
        {"visual.transformer.resblocks", "vision_model.encoder.layers"},
        {"transformer.resblocks", "text_model.encoder.layers"},
        {"token_embedding", "text_model.embeddings.token_embedding"},
        {"positional_embedding",
         "text_model.embeddings.position_embedding.weight"},
        {"ln_final", "text_model.final_layer_norm"},
        {"text_projection", "text_projection.weight"}};
    for (const auto& [ours, theirs] : kNames) {
      if (!name.starts_with(ours)) continue;
      name = theirs + name.substr(std::string(ours).size());
      break;
    }
    static const std::pair<const char*, const char*> kParts[] = {
        {"ln_1", "layer_norm1"},
        {"ln_2", "layer_norm2"},
        {"attn.out_proj", "self_attn.out_proj"},
        {"c_fc", "fc1"},
        {"c_proj", "fc2"}};
    for (const auto& [ours, theirs] : kParts) {
      const size_t at = name.find(ours);
      if (at != std::string::npos) {
        name.replace(at, std::string(ours).size(), theirs);
      }
    }
    return name;
  }

  RandomStream random_{5, 0};
  TestTensors tensors_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_TESTS_SEMANTICS_CLIP_EXPORT_RANDOM_CLIP_H_
