// SPDX-License-Identifier: BSD-3-Clause
// What the shapes of a CLIP's tensors do not tell: numbers of heads,
// activations, colours. It stands in a JSON file beside the weights.

#ifndef FREEGS_SEMANTICS_CLIP_EXPORT_CLIP_CONFIG_H_
#define FREEGS_SEMANTICS_CLIP_EXPORT_CLIP_CONFIG_H_

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "core/status.h"

namespace freegs::semantics {

struct TowerConfig {
  int heads = 0;
  std::string activation;  // "quick_gelu" or "gelu"
  double epsilon = 1e-5;
  // Sizes that the file names, by the name of the field, for comparison with
  // the tensors.
  std::map<std::string, int> sizes;
};

struct ClipConfig {
  TowerConfig visual;
  TowerConfig text;
  struct Colors {
    std::array<double, 3> mean;
    std::array<double, 3> std;
  };
  std::optional<Colors> colors;
};

// Reads config.json of Hugging Face's transformers, and
// preprocessor_config.json where there is one. Fields that are missing have the
// defaults of transformers. sizes: "width", "layers", "patch", "image_size",
// "context_length", "vocab_size". kMissingDependency names the file and the
// fault.
StatusOr<ClipConfig> ReadHuggingFaceConfig(const std::filesystem::path& folder);

// Reads open_clip_config.json of OpenCLIP. visual_width, of the tensors, gives
// the number of heads, of which only the width is named.
StatusOr<ClipConfig> ReadOpenClipConfig(const std::filesystem::path& folder,
                                        int visual_width);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_EXPORT_CLIP_CONFIG_H_
