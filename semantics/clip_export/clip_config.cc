// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip_export/clip_config.h"

#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_fields.h"

namespace freegs::semantics {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr uint64_t kMaxConfigBytes = 1 << 20;
constexpr int kMaxConfigSize = 1 << 24;

Status ConfigError(const Status& fault) {
  return MissingDependencyError(fault.message());
}

StatusOr<json> ReadConfig(const fs::path& path) {
  const StatusOr<std::string> text = ReadFile(path, kMaxConfigBytes);
  if (!text.ok()) return ConfigError(text.status());
  StatusOr<json> config = ParseJsonObject(*text, path.string());
  if (!config.ok()) return ConfigError(config.status());
  return config;
}

// A member that is an object, or an empty one when it is missing.
const json& ObjectOrEmpty(JsonObjectReader& reader, const char* key) {
  static const json empty = json::object();
  return reader.Has(key) && !reader.IsNull(key) ? reader.Object(key) : empty;
}

int IntegerOr(JsonObjectReader& reader, const char* key, int otherwise) {
  return reader.Has(key) ? reader.Integer(key, 1, kMaxConfigSize) : otherwise;
}

using SizeNames = std::pair<const char*, const char*>;  // Theirs, ours.

void ReadSizes(JsonObjectReader& reader,
               std::initializer_list<SizeNames> names,
               TowerConfig* tower) {
  for (const auto& [theirs, ours] : names) {
    if (reader.Has(theirs)) {
      tower->sizes[ours] = reader.Integer(theirs, 1, kMaxConfigSize);
    }
  }
}

std::array<double, 3> ReadTriple(JsonObjectReader& reader,
                                 const char* key,
                                 double min) {
  const Eigen::Vector3d values = reader.Vector3(key);
  if (values.minCoeff() < min || values.maxCoeff() > 100) {
    reader.Fail(key, "is out of range");
  }
  return {values[0], values[1], values[2]};
}

void ReadColors(JsonObjectReader& reader,
                const char* mean,
                const char* std,
                ClipConfig* config) {
  if (!reader.Has(mean) && !reader.Has(std)) return;
  config->colors = ClipConfig::Colors{ReadTriple(reader, mean, -100),
                                      ReadTriple(reader, std, 1e-6)};
}

// Reads what both towers of OpenCLIP may have. pooling: the kind that is
// exported.
void ReadOpenClipTower(JsonObjectReader& reader,
                       const std::string& pooling,
                       Status* status,
                       TowerConfig* tower) {
  JsonObjectReader norm(ObjectOrEmpty(reader, "norm_kwargs"),
                        reader.Where("norm_kwargs"),
                        "",
                        status);
  if (norm.Has("eps")) tower->epsilon = norm.Number("eps", 1e-12, 1);
  if (!ObjectOrEmpty(reader, "act_kwargs").empty()) {
    reader.Fail("act_kwargs", "is not empty; such activations are not known");
  }
  if (reader.Has("pool_type") && reader.Text("pool_type") != pooling) {
    reader.Fail("pool_type", "is not " + pooling + "; others are not known");
  }
}

// heads: the default of transformers.
TowerConfig ReadHuggingFaceTower(JsonObjectReader& root,
                                 const std::string& source,
                                 const char* key,
                                 int heads,
                                 Status* status) {
  TowerConfig tower;
  JsonObjectReader reader(ObjectOrEmpty(root, key), source, key, status);
  tower.heads = IntegerOr(reader, "num_attention_heads", heads);
  tower.activation =
      reader.Has("hidden_act") ? reader.Text("hidden_act") : "quick_gelu";
  if (reader.Has("layer_norm_eps")) {
    tower.epsilon = reader.Number("layer_norm_eps", 1e-12, 1);
  }
  if (tower.activation != "quick_gelu" && tower.activation != "gelu") {
    reader.Fail("hidden_act",
                "is " + tower.activation + "; known are quick_gelu and gelu");
  }
  ReadSizes(reader,
            {{"hidden_size", "width"},
             {"num_hidden_layers", "layers"},
             {"patch_size", "patch"},
             {"image_size", "image_size"},
             {"max_position_embeddings", "context_length"},
             {"vocab_size", "vocab_size"}},
            &tower);
  return tower;
}

}  // namespace

StatusOr<ClipConfig> ReadHuggingFaceConfig(const fs::path& folder) {
  const fs::path path = folder / "config.json";
  FREEGS_ASSIGN_OR_RETURN(const json root, ReadConfig(path));
  Status status;
  JsonObjectReader reader(root, path.string(), "", &status);
  if (reader.Has("model_type") && reader.Text("model_type") != "clip") {
    reader.Fail("model_type", "is not clip");
  }
  ClipConfig config;
  config.visual =
      ReadHuggingFaceTower(reader, path.string(), "vision_config", 12, &status);
  config.text =
      ReadHuggingFaceTower(reader, path.string(), "text_config", 8, &status);
  if (!status.ok()) return ConfigError(status);

  const fs::path colors = folder / "preprocessor_config.json";
  std::error_code error;
  if (!fs::exists(colors, error)) return config;
  FREEGS_ASSIGN_OR_RETURN(const json preprocessor, ReadConfig(colors));
  JsonObjectReader fields(preprocessor, colors.string(), "", &status);
  ReadColors(fields, "image_mean", "image_std", &config);
  if (!status.ok()) return ConfigError(status);
  return config;
}

StatusOr<ClipConfig> ReadOpenClipConfig(const fs::path& folder,
                                        int visual_width) {
  const fs::path path = folder / "open_clip_config.json";
  FREEGS_ASSIGN_OR_RETURN(const json root, ReadConfig(path));
  Status status;
  JsonObjectReader reader(root, path.string(), "", &status);
  JsonObjectReader model(
      reader.Object("model_cfg"), path.string(), "model_cfg", &status);
  const std::string activation =
      model.Has("quick_gelu") && model.Bool("quick_gelu") ? "quick_gelu"
                                                          : "gelu";
  JsonObjectReader vision(model.Object("vision_cfg"),
                          path.string(),
                          "model_cfg.vision_cfg",
                          &status);
  JsonObjectReader words(
      model.Object("text_cfg"), path.string(), "model_cfg.text_cfg", &status);
  ClipConfig config;
  config.visual.activation = config.text.activation = activation;
  const int head_width = IntegerOr(vision, "head_width", 64);
  if (visual_width % head_width != 0) {
    vision.Fail("head_width",
                "does not divide the width of " + std::to_string(visual_width));
  }
  config.visual.heads = visual_width / head_width;
  config.text.heads = IntegerOr(words, "heads", 8);
  ReadOpenClipTower(vision, "tok", &status, &config.visual);
  ReadOpenClipTower(words, "argmax", &status, &config.text);
  if (words.Has("no_causal_mask") && words.Bool("no_causal_mask")) {
    words.Fail("no_causal_mask", "is true; such networks are not known");
  }
  ReadSizes(vision,
            {{"width", "width"},
             {"layers", "layers"},
             {"patch_size", "patch"},
             {"image_size", "image_size"}},
            &config.visual);
  ReadSizes(words,
            {{"width", "width"},
             {"layers", "layers"},
             {"context_length", "context_length"},
             {"vocab_size", "vocab_size"}},
            &config.text);
  JsonObjectReader preprocess(ObjectOrEmpty(reader, "preprocess_cfg"),
                              path.string(),
                              "preprocess_cfg",
                              &status);
  ReadColors(preprocess, "mean", "std", &config);
  if (!status.ok()) return ConfigError(status);
  return config;
}

}  // namespace freegs::semantics
