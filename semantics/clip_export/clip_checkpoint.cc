// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip_export/clip_checkpoint.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <system_error>
#include <tuple>
#include <utility>

#include "semantics/clip_export/clip_config.h"

namespace freegs::semantics {
namespace {

namespace fs = std::filesystem;

constexpr char kHuggingFaceFile[] = "model.safetensors";
constexpr char kOpenClipFile[] = "open_clip_model.safetensors";
// The largest values that model.json allows.
constexpr int kMaxWidth = 1 << 14;
constexpr int kMaxImageSize = 4096;
constexpr int kMaxGrid = 1024;
constexpr int kMaxContext = 4096;
constexpr int kMaxLayers = 1000;
constexpr int64_t kMaxNetworkElements = int64_t{1} << 29;

// The file of weights that `path` means.
StatusOr<fs::path> WeightsFile(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    for (const char* name : {kHuggingFaceFile, kOpenClipFile}) {
      if (fs::exists(path / name, error)) return path / name;
    }
    return MissingDependencyError(path.string() + ": it has neither " +
                                  kHuggingFaceFile + " nor " + kOpenClipFile +
                                  "; other formats are not read");
  }
  const std::string suffix = path.extension().string();
  for (const char* pickle : {".pt", ".pth", ".bin", ".ckpt", ".pkl"}) {
    if (suffix != pickle) continue;
    return MissingDependencyError(
        path.string() +
        ": files of this kind can run any program when they are read, so they "
        "are not; give the model's .safetensors (for OpenAI's own .pt files "
        "there is scripts/export_clip.py)");
  }
  if (!fs::exists(path, error)) {
    return BadInputError(path.string() + ": no such file or folder");
  }
  if (suffix != ".safetensors") {
    return MissingDependencyError(path.string() +
                                  ": not a .safetensors file or a folder");
  }
  return path;
}

}  // namespace

std::string ClipCheckpoint::BlockName(Tower tower, int layer) const {
  return layout_->BlockName(static_cast<int>(tower), layer);
}

StatusOr<std::vector<int>> ClipCheckpoint::Sides(const std::string& name,
                                                 size_t count) const {
  const auto found = file_.tensors().find(name);
  if (found == file_.tensors().end()) {
    return file_.Error("it has no tensor " + name +
                       ": not a CLIP with a vision transformer");
  }
  const std::vector<int64_t>& shape = found->second.shape;
  if (shape.size() != count) {
    return file_.Error("tensor " + name + " is " + ShapeText(shape) +
                       ", which has not " + std::to_string(count) + " sides");
  }
  std::vector<int> sides;
  for (const int64_t side : shape) {
    if (side < 1 || side > (1 << 24)) {
      return file_.Error("tensor " + name + " is " + ShapeText(shape) +
                         ", which no CLIP has");
    }
    sides.push_back(static_cast<int>(side));
  }
  return sides;
}

int ClipCheckpoint::CountLayers(Tower tower) const {
  const std::string prefix = layout_->blocks[static_cast<int>(tower)];
  int count = 0;
  for (auto it = file_.tensors().lower_bound(prefix);
       it != file_.tensors().end() && it->first.starts_with(prefix);
       ++it) {
    int layer = 0;
    const char* begin = it->first.data() + prefix.size();
    const char* end = it->first.data() + it->first.size();
    if (std::from_chars(begin, end, layer).ec == std::errc() &&
        layer < kMaxLayers) {
      count = std::max(count, layer + 1);
    }
  }
  return count;
}

Status ClipCheckpoint::ReadSizes() {
  ClipArchitecture& a = architecture_;
  FREEGS_ASSIGN_OR_RETURN(const auto patches, Sides(layout_->patches, 4));
  FREEGS_ASSIGN_OR_RETURN(const auto positions,
                          Sides(layout_->image_positions, 2));
  FREEGS_ASSIGN_OR_RETURN(const auto context,
                          Sides(layout_->text_positions, 2));
  FREEGS_ASSIGN_OR_RETURN(const auto tokens, Sides(layout_->tokens, 2));
  FREEGS_ASSIGN_OR_RETURN(const auto projection,
                          Sides(layout_->projections[0], 2));
  a.visual.width = patches[0];
  a.patch = patches[3];
  a.visual.positions = positions[0];
  const auto grid =
      static_cast<int>(std::lround(std::sqrt(positions[0] - 1.0)));
  if (grid < 1 || grid > kMaxGrid || grid * grid + 1 != positions[0] ||
      a.patch > kMaxImageSize) {
    return file_.Error(std::to_string(positions[0]) +
                       " positions of an image are not a square grid and one "
                       "more");
  }
  a.image_size = grid * a.patch;
  a.embedding_dim = projection[layout_->projections_have_rows ? 0 : 1];
  a.text.width = tokens[1];
  a.text.positions = context[0];
  a.vocab_size = tokens[0];
  a.visual.layers = CountLayers(Tower::kVisual);
  a.text.layers = CountLayers(Tower::kText);
  return Status();
}

Status ClipCheckpoint::CheckSizes() const {
  const ClipArchitecture& a = architecture_;
  const std::tuple<const char*, int, int, int> limits[] = {
      {"width of the image network", a.visual.width, 1, kMaxWidth},
      {"width of the text network", a.text.width, 1, kMaxWidth},
      {"size of the vectors", a.embedding_dim, 1, kMaxWidth},
      {"image size", a.image_size, 8, kMaxImageSize},
      {"context length", a.text.positions, 3, kMaxContext},
      {"vocabulary", a.vocab_size, 515, 49408},
      {"number of layers of the image network",
       a.visual.layers,
       1,
       kMaxLayers - 1},
      {"number of layers of the text network",
       a.text.layers,
       1,
       kMaxLayers - 1}};
  for (const auto& [what, value, min, max] : limits) {
    if (value < min || value > max) {
      return file_.Error("the " + std::string(what) + " is " +
                         std::to_string(value) + ", not within " +
                         std::to_string(min) + " .. " + std::to_string(max));
    }
  }
  for (const TransformerShape* tower : {&a.visual, &a.text}) {
    if (tower->heads < 1 || tower->width % tower->heads != 0) {
      return file_.Error(std::to_string(tower->heads) +
                         " heads, which the file beside it names, do not "
                         "divide the width of " +
                         std::to_string(tower->width));
    }
    // Matrices of attention and MLP; anything else is small beside them.
    if (int64_t{12} * tower->layers * tower->width * tower->width >
        kMaxNetworkElements) {
      return file_.Error(
          "a network of " + std::to_string(tower->layers) +
          " layers of width " + std::to_string(tower->width) +
          " is larger than the 2 GB that an ONNX file can hold; take a smaller "
          "model");
    }
  }
  return Status();
}

// All tensors that the networks need are there, and no others: a network with
// further parts would be another one without them.
Status ClipCheckpoint::CheckNames() const {
  const std::set<std::string> wanted = TensorNames(
      *layout_, architecture_.visual.layers, architecture_.text.layers);
  for (const std::string& name : wanted) {
    if (file_.tensors().count(name) == 0) {
      return file_.Error("it has no tensor " + name);
    }
  }
  const std::set<std::string> unused(layout_->unused.begin(),
                                     layout_->unused.end());
  for (const auto& [name, entry] : file_.tensors()) {
    if (wanted.count(name) == 0 && unused.count(name) == 0) {
      return file_.Error("its tensor " + name +
                         " belongs to no CLIP that this program knows");
    }
  }
  return Status();
}

StatusOr<ClipCheckpoint> ClipCheckpoint::Open(const fs::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const fs::path weights, WeightsFile(path));
  FREEGS_ASSIGN_OR_RETURN(SafetensorsFile file, SafetensorsFile::Open(weights));
  ClipCheckpoint checkpoint(std::move(file));
  const auto& tensors = checkpoint.file_.tensors();
  const bool open_clip = tensors.count(OpenClipLayout().patches) > 0;
  if (!open_clip && tensors.count(HuggingFaceLayout().patches) == 0) {
    return checkpoint.file_.Error(
        std::string("it has neither ") + HuggingFaceLayout().patches +
        " (Hugging Face) nor " + OpenClipLayout().patches +
        " (OpenCLIP): not a CLIP with a vision transformer");
  }
  checkpoint.layout_ = open_clip ? &OpenClipLayout() : &HuggingFaceLayout();
  FREEGS_RETURN_IF_ERROR(checkpoint.ReadSizes());

  ClipArchitecture& a = checkpoint.architecture_;
  const fs::path folder = weights.parent_path();
  FREEGS_ASSIGN_OR_RETURN(const ClipConfig config,
                          open_clip ? ReadOpenClipConfig(folder, a.visual.width)
                                    : ReadHuggingFaceConfig(folder));
  const auto apply = [](const TowerConfig& from, TransformerShape* to) {
    to->heads = from.heads;
    to->activation = from.activation == "gelu" ? MlpActivation::kGelu
                                               : MlpActivation::kQuickGelu;
    to->epsilon = from.epsilon;
  };
  apply(config.visual, &a.visual);
  apply(config.text, &a.text);
  if (config.colors.has_value()) {
    a.mean = config.colors->mean;
    a.std = config.colors->std;
  }
  const std::pair<const TowerConfig&, std::map<std::string, int>> sizes[] = {
      {config.visual,
       {{"width", a.visual.width},
        {"layers", a.visual.layers},
        {"patch", a.patch},
        {"image_size", a.image_size}}},
      {config.text,
       {{"width", a.text.width},
        {"layers", a.text.layers},
        {"context_length", a.text.positions},
        {"vocab_size", a.vocab_size}}}};
  for (const auto& [tower, own] : sizes) {
    for (const auto& [name, value] : own) {
      const auto named = tower.sizes.find(name);
      if (named != tower.sizes.end() && named->second != value) {
        return checkpoint.file_.Error(
            "its tensors have a " + name + " of " + std::to_string(value) +
            ", but the file beside it names " + std::to_string(named->second));
      }
    }
  }
  FREEGS_RETURN_IF_ERROR(checkpoint.CheckSizes());
  FREEGS_RETURN_IF_ERROR(checkpoint.CheckNames());
  return checkpoint;
}

StatusOr<std::vector<float>> ClipCheckpoint::Patches() const {
  const int patch = architecture_.patch;
  return file_.Read(layout_->patches,
                    {architecture_.visual.width, 3, patch, patch});
}

StatusOr<std::vector<float>> ClipCheckpoint::ClassToken() const {
  return file_.Read(layout_->class_token, {architecture_.visual.width});
}

StatusOr<std::vector<float>> ClipCheckpoint::Positions(Tower tower) const {
  const TransformerShape& shape = Shape(tower);
  return file_.Read(tower == Tower::kVisual ? layout_->image_positions
                                            : layout_->text_positions,
                    {shape.positions, shape.width});
}

StatusOr<std::vector<float>> ClipCheckpoint::TokenVectors() const {
  return file_.Read(layout_->tokens,
                    {architecture_.vocab_size, architecture_.text.width});
}

StatusOr<LayerNorm> ClipCheckpoint::ReadNorm(const std::string& name,
                                             int width) const {
  FREEGS_ASSIGN_OR_RETURN(auto gain, file_.Read(name + ".weight", {width}));
  FREEGS_ASSIGN_OR_RETURN(auto offset, file_.Read(name + ".bias", {width}));
  return LayerNorm{std::move(gain), std::move(offset)};
}

StatusOr<LayerNorm> ClipCheckpoint::FirstNorm() const {
  return ReadNorm(layout_->first_norm, architecture_.visual.width);
}

StatusOr<LayerNorm> ClipCheckpoint::LastNorm(Tower tower) const {
  return ReadNorm(layout_->last_norms[static_cast<int>(tower)],
                  Shape(tower).width);
}

StatusOr<LinearLayer> ClipCheckpoint::Projection(Tower tower) const {
  const int rows = architecture_.embedding_dim;
  const int columns = Shape(tower).width;
  const char* name = layout_->projections[static_cast<int>(tower)];
  LinearLayer layer{rows, columns, {}, std::vector<float>(rows, 0.0f)};
  if (layout_->projections_have_rows) {
    FREEGS_ASSIGN_OR_RETURN(layer.weight, file_.Read(name, {rows, columns}));
    return layer;
  }
  FREEGS_ASSIGN_OR_RETURN(const std::vector<float> transposed,
                          file_.Read(name, {columns, rows}));
  layer.weight.resize(transposed.size());
  for (size_t i = 0; i < static_cast<size_t>(rows); ++i) {
    for (size_t j = 0; j < static_cast<size_t>(columns); ++j) {
      layer.weight[i * columns + j] = transposed[j * rows + i];
    }
  }
  return layer;
}

StatusOr<LayerNorm> ClipCheckpoint::Norm(Tower tower,
                                         int layer,
                                         BlockNorm part) const {
  return ReadNorm(BlockName(tower, layer) + layout_->norms[part],
                  Shape(tower).width);
}

StatusOr<LinearLayer> ClipCheckpoint::Linear(Tower tower,
                                             int layer,
                                             BlockLinear part) const {
  const int width = Shape(tower).width;
  const std::string block = BlockName(tower, layer);
  LinearLayer linear{part == kMlpIn ? 4 * width : width,
                     part == kMlpOut ? 4 * width : width,
                     {},
                     {}};
  const bool joint = layout_->joint_qkv != nullptr && part <= kValue;
  const std::string name =
      joint ? block + layout_->joint_qkv : block + layout_->linears[part] + ".";
  const int rows = joint ? 3 * width : linear.rows;
  FREEGS_ASSIGN_OR_RETURN(linear.weight,
                          file_.Read(name + "weight", {rows, linear.columns}));
  FREEGS_ASSIGN_OR_RETURN(linear.bias, file_.Read(name + "bias", {rows}));
  if (joint) {
    const auto third = [part](std::vector<float>* values) {
      const auto count = static_cast<std::ptrdiff_t>(values->size() / 3);
      *values = {values->begin() + part * count,
                 values->begin() + (part + 1) * count};
    };
    third(&linear.weight);
    third(&linear.bias);
  }
  return linear;
}

}  // namespace freegs::semantics
