// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/scene_size.h"

#include <fstream>
#include <string>
#include <system_error>

#include "core/io/files.h"
#include "splat/scene/ply_header.h"
#include "splat/scene/spz_format.h"

namespace freegs::stages {

std::optional<int64_t> CountGaussians(const std::filesystem::path& path) {
  constexpr size_t kEnough = 1 << 16;  // A header has about 1500 bytes.
  std::error_code error;
  const uint64_t size = std::filesystem::file_size(path, error);
  if (error) return std::nullopt;
  std::string begin(kEnough, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<size_t>(file.gcount()));
  if (LowerSuffix(path) == ".spz") {
    const StatusOr<size_t> count = splat::CountSpzGaussians(begin, size);
    if (!count.ok()) return std::nullopt;
    return static_cast<int64_t>(*count);
  }
  const StatusOr<splat::PlyHeader> header = splat::ParsePlyHeader(begin);
  if (!header.ok()) return std::nullopt;
  for (const splat::PlyElement& element : header->elements) {
    if (element.name != "vertex") continue;
    // A count that the file cannot hold is wrong.
    const uint64_t bytes = element.MinItemBytes(header->format);
    if (bytes == 0 || element.count > size / bytes) return std::nullopt;
    return static_cast<int64_t>(element.count);
  }
  return std::nullopt;
}

}  // namespace freegs::stages
