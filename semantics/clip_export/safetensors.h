// SPDX-License-Identifier: BSD-3-Clause
// Reads safetensors, the file format for the numbers of a network:
//   uint64     length of the header, little-endian
//   header     JSON: {"name": {"dtype": "F32", "shape": [2, 3],
//                              "data_offsets": [begin, end]}, ...,
//                    "__metadata__": texts, which are ignored}
//   numbers    one tensor after another, row-major, little-endian
// https://github.com/huggingface/safetensors describes it.

#ifndef FREEGS_SEMANTICS_CLIP_EXPORT_SAFETENSORS_H_
#define FREEGS_SEMANTICS_CLIP_EXPORT_SAFETENSORS_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/status.h"

namespace freegs::semantics {

struct TensorEntry {
  std::string dtype;           // "F32", "F16", "BF16", "I64", ...
  std::vector<int64_t> shape;  // Empty for a single number.
  uint64_t begin = 0;          // Bytes from the beginning of the numbers.
  uint64_t end = 0;
};

// The tensors of a file. Only the header is kept in memory; the numbers of a
// tensor are read when they are asked for.
class SafetensorsFile {
 public:
  // kMissingDependency names the file and the fault. The tensors must cover the
  // bytes behind the header without a gap and without an overlap, so a file
  // that was cut is refused here.
  static StatusOr<SafetensorsFile> Open(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  const std::map<std::string, TensorEntry>& tensors() const { return tensors_; }

  // Returns the numbers of a tensor of type F32, F16 or BF16, row-major.
  // kMissingDependency if there is no such tensor, if its type or its shape is
  // another, if it has more than 2^29 numbers, or if one is not finite.
  StatusOr<std::vector<float>> Read(const std::string& name,
                                    const std::vector<int64_t>& shape) const;

  // The error for a fault in this file.
  Status Error(const std::string& fault) const;

 private:
  std::filesystem::path path_;
  uint64_t data_begin_ = 0;  // Bytes of the file before the numbers.
  std::map<std::string, TensorEntry> tensors_;
};

// Such as "768 x 3 x 16 x 16", or "one number" for no sides.
std::string ShapeText(const std::vector<int64_t>& shape);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_EXPORT_SAFETENSORS_H_
