// SPDX-License-Identifier: BSD-3-Clause
// The folder of files that make up a CLIP model. semantics/clip_export writes
// such a folder from the weights of a CLIP.

#ifndef FREEGS_SEMANTICS_CLIP_MODEL_FOLDER_H_
#define FREEGS_SEMANTICS_CLIP_MODEL_FOLDER_H_

#include <filesystem>
#include <string>

#include "core/status.h"
#include "semantics/clip/byte_pair_tokenizer.h"
#include "semantics/clip/model_info.h"
#include "semantics/clip/token_table.h"

namespace freegs::semantics {

// The folder holds, with S, D, G, C, W from model.json:
//   visual.onnx      1 x 3 x S x S image -> 1 x D
//   dense.onnx       1 x 3 x S x S image -> 1 x D x G x G (MaskCLIP: the last
//                    block by its value projection only)
//   dense448.onnx    or any other names that model.json gives: the same at
//                    other sizes; may be absent
//   upsampler.onnx   inputs "features", 1 x D x G x G as dense.onnx gives them,
//                    and "image", 1 x 3 x S x S as it takes them ->
//                    1 x D x U x U; only where model.json has upsampled_size U
//   text.onnx        1 x C x W token vectors -> 1 x C x D, one output for every
//                    position; that of the end token is the text's
//   text_embedding   token vectors, see TokenTable
//   vocab            byte-pair merges, see BytePairTokenizer; plain or gzip
//   model.json       see ModelInfo
// Images have mean subtracted and are divided by std. Outputs are not
// normalised. The networks keep to what OpenCV 4.6 can load.
struct ModelFolder {
  std::filesystem::path path;
  ModelInfo info;

  // Reads model.json and compares the size and hash of every file that it
  // lists. Everything that is missing or wrong is kMissingDependency; the
  // message names the file and the fault, and says what to do.
  static StatusOr<ModelFolder> Open(const std::filesystem::path& path);

  // Loads a file of the folder and checks that it fits model.json. Errors as
  // Open().
  StatusOr<BytePairTokenizer> LoadTokenizer() const;
  StatusOr<TokenTable> LoadTokenTable() const;

  // The error for a fault in a file of this folder.
  Status FileError(const std::string& name, const std::string& fault) const;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_MODEL_FOLDER_H_
