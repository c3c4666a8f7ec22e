// SPDX-License-Identifier: BSD-3-Clause
// The file model.json, in which a model folder describes itself.

#ifndef FREEGS_SEMANTICS_CLIP_MODEL_INFO_H_
#define FREEGS_SEMANTICS_CLIP_MODEL_INFO_H_

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"

namespace freegs::semantics {

// A network that computes dense features at one image size.
struct DenseNetwork {
  std::string file;
  int image_size = 0;  // Width and height of the image in pixels.
  int grid = 0;        // Width and height of the features.
};

struct ModelFile {
  uint64_t bytes = 0;
  std::string hash;  // HashFile() of core/io/files.h.
};

// model.json:
//   {"format": "FreeGS CLIP", "version": 1,
//    "name": "ViT-B/16",             what people call the model
//    "licence": "MIT",               of the weights
//    "origin": "...",                where they came from, in words
//    "embedding_dim": 512,           D, shared by images and texts
//    "image_size": 224,              of visual.onnx, pixels
//    "mean": [r, g, b], "std": [r, g, b],        of colours in [0, 1]
//    "dense": [{"file": "dense.onnx", "image_size": 224, "grid": 14}, ...],
//    "upsampled_size": 224,          of upsampler.onnx; only where there is one
//    "context_length": 77, "text_width": 512, "vocab_size": 49408,
//    "vocabulary": [["red", "green", ...], ["ball", "box", ...], ...],
//        words to name things by, in groups of which one fits; optional
//    "canonical": ["object", ...],   what says nothing in particular; optional
//    "min_word_confidence": 0.8,     of words that name things; optional, see
//                                    semantics/queries/instance_words.h
//    "files": {"visual.onnx": {"bytes": 12, "hash": "32 hex digits"}, ...}}
// Fields that are not listed here are for people and other programs.
struct ModelInfo {
  std::string name;
  std::string licence;
  std::string origin;
  int embedding_dim = 0;
  int image_size = 0;
  std::array<float, 3> mean = {};
  std::array<float, 3> std = {};
  std::vector<DenseNetwork> dense;  // At least one, the first in dense.onnx.
  int upsampled_size = 0;  // Pixels that upsampler.onnx gives; 0: no such file.
  int context_length = 0;
  int text_width = 0;
  int vocab_size = 0;
  std::vector<std::vector<std::string>> vocabulary;  // Groups of words.
  std::vector<std::string> canonical;      // See ClipEncoder; or none.
  double min_word_confidence = 0;          // 0: every word may name a thing.
  std::map<std::string, ModelFile> files;  // By name, no folders in it.

  // Returns a hash of everything that changes the vectors of the model: the
  // content of the files and the numbers about them. Features that were made
  // before stay valid when only words change, so the vocabulary, the canonical
  // phrases, min_word_confidence, and names do not count.
  std::string Hash() const;
};

// kBadInput names the field and the fault. All files that a model folder must
// have (see model_folder.h) are listed in `files`.
StatusOr<ModelInfo> ParseModelInfo(std::string_view json);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_MODEL_INFO_H_
