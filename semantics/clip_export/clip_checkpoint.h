// SPDX-License-Identifier: BSD-3-Clause
// The weights of a CLIP with a vision transformer, from a safetensors file in
// the layout of Hugging Face's transformers or of OpenCLIP. Both hold the same
// numbers under other names; here they have one name.

#ifndef FREEGS_SEMANTICS_CLIP_EXPORT_CLIP_CHECKPOINT_H_
#define FREEGS_SEMANTICS_CLIP_EXPORT_CLIP_CHECKPOINT_H_

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "core/status.h"
#include "semantics/clip_export/clip_layout.h"
#include "semantics/clip_export/safetensors.h"

namespace freegs::semantics {

enum class MlpActivation {
  kQuickGelu,  // x sigmoid(1.702 x), of OpenAI's models
  kGelu,       // x Phi(x)
};

struct TransformerShape {
  int width = 0;
  int layers = 0;
  int heads = 0;
  int positions = 0;  // The context length, in the text network.
  MlpActivation activation = MlpActivation::kQuickGelu;
  double epsilon = 1e-5;  // What layer norms add to variances.
};

struct ClipArchitecture {
  TransformerShape visual;
  TransformerShape text;
  int image_size = 0;
  int patch = 0;
  int embedding_dim = 0;
  int vocab_size = 0;
  // Mean and standard deviation of colours in [0, 1], which normalise the
  // image: OpenAI's, unless a file beside the weights names others.
  std::array<double, 3> mean = {0.48145466, 0.4578275, 0.40821073};
  std::array<double, 3> std = {0.26862954, 0.26130258, 0.27577711};
};

enum class Tower { kVisual, kText };

// y = weight x + bias; the weight is rows x columns, row-major.
struct LinearLayer {
  int rows = 0;
  int columns = 0;
  std::vector<float> weight;
  std::vector<float> bias;
};

struct LayerNorm {
  std::vector<float> gain;
  std::vector<float> offset;
};

// Numbers are read from the file when they are asked for. Every function gives
// kMissingDependency, with the name of the file and the fault, for what is
// missing or does not fit.
class ClipCheckpoint {
 public:
  // path: a .safetensors file, or a folder with model.safetensors (Hugging
  // Face) or open_clip_model.safetensors (OpenCLIP). Beside the file lies
  // config.json (and, where there is one, preprocessor_config.json) or
  // open_clip_config.json. All tensors must be there with the right shapes, and
  // none that this program would not use. Files that hold pickled Python
  // objects (.pt, .bin, .ckpt, .pth) are never opened. kBadInput where nothing
  // is at `path`.
  static StatusOr<ClipCheckpoint> Open(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return file_.path(); }
  const ClipArchitecture& architecture() const { return architecture_; }

  StatusOr<std::vector<float>> Patches() const;     // width x 3 x patch x patch
  StatusOr<std::vector<float>> ClassToken() const;  // width
  StatusOr<std::vector<float>> Positions(Tower t) const;  // positions x width
  StatusOr<std::vector<float>> TokenVectors() const;  // vocab_size x text width

  // FirstNorm normalises the positions of the image network before its blocks,
  // and LastNorm what the blocks of either network give.
  StatusOr<LayerNorm> FirstNorm() const;
  StatusOr<LayerNorm> LastNorm(Tower tower) const;
  StatusOr<LinearLayer> Projection(Tower tower) const;  // Bias 0.

  // Parts of a residual attention block.
  enum BlockNorm { kBeforeAttention, kBeforeMlp };
  enum BlockLinear { kQuery, kKey, kValue, kAttentionOut, kMlpIn, kMlpOut };
  StatusOr<LayerNorm> Norm(Tower tower, int layer, BlockNorm part) const;
  StatusOr<LinearLayer> Linear(Tower tower, int layer, BlockLinear part) const;

 private:
  explicit ClipCheckpoint(SafetensorsFile file) : file_(std::move(file)) {}

  const TransformerShape& Shape(Tower tower) const {
    return tower == Tower::kVisual ? architecture_.visual : architecture_.text;
  }
  std::string BlockName(Tower tower, int layer) const;
  StatusOr<std::vector<int>> Sides(const std::string& name, size_t count) const;
  int CountLayers(Tower tower) const;
  Status ReadSizes();
  Status CheckSizes() const;
  Status CheckNames() const;
  StatusOr<LayerNorm> ReadNorm(const std::string& name, int width) const;

  SafetensorsFile file_;
  const ClipLayout* layout_ = nullptr;
  ClipArchitecture architecture_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_EXPORT_CLIP_CHECKPOINT_H_
