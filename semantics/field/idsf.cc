// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/idsf.h"

#include <bit>
#include <cmath>
#include <cstring>

#include <xxhash.h>

#include "core/io/files.h"

namespace freegs::semantics {
namespace {

static_assert(std::endian::native == std::endian::little,
              "numbers are copied to little-endian files as they are");

constexpr std::string_view kMagic = "FREEGSID";
constexpr uint32_t kVersion = 1;
constexpr size_t kHeaderSize = 8 + 4 + 4 + 8;
constexpr size_t kChecksumSize = 8;
constexpr uint32_t kMaxFeatureDim = 1 << 16;

template <typename T>
void Append(const T* values, size_t count, std::string* content) {
  if (count == 0) return;
  content->append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

template <typename T>
T Take(std::string_view content, size_t offset) {
  T value;
  std::memcpy(&value, content.data() + offset, sizeof(T));
  return value;
}

}  // namespace

StatusOr<std::string> SerializeIdsf(const Idsf& idsf) {
  const uint64_t count = idsf.instances.size();
  if (idsf.feature_dim < 0 ||
      static_cast<uint32_t>(idsf.feature_dim) > kMaxFeatureDim ||
      idsf.features.size() != count * idsf.feature_dim) {
    return InvalidArgumentError(
        "the semantic field holds " + std::to_string(idsf.features.size()) +
        " feature values, not " + std::to_string(count) + " x " +
        std::to_string(idsf.feature_dim));
  }
  const auto dim = static_cast<uint32_t>(idsf.feature_dim);
  std::string content(kMagic);
  content.reserve(kHeaderSize + 4 * (count + idsf.features.size()) +
                  kChecksumSize);
  Append(&kVersion, 1, &content);
  Append(&dim, 1, &content);
  Append(&count, 1, &content);
  Append(idsf.instances.data(), idsf.instances.size(), &content);
  Append(idsf.features.data(), idsf.features.size(), &content);
  const uint64_t checksum = XXH3_64bits(content.data(), content.size());
  Append(&checksum, 1, &content);
  return content;
}

Status WriteIdsf(const std::filesystem::path& path, const Idsf& idsf) {
  FREEGS_ASSIGN_OR_RETURN(const std::string content, SerializeIdsf(idsf));
  return WriteFileAtomic(path, content);
}

StatusOr<Idsf> ParseIdsf(std::string_view content) {
  if (content.size() < kHeaderSize + kChecksumSize ||
      content.substr(0, kMagic.size()) != kMagic) {
    return BadInputError("this is not a semantic field (idsf.bin)");
  }
  const auto version = Take<uint32_t>(content, 8);
  if (version != kVersion) {
    return BadInputError("version " + std::to_string(version) +
                         " of the file is not known; a newer program wrote it");
  }
  const auto dim = Take<uint32_t>(content, 12);
  const auto count = Take<uint64_t>(content, 16);
  const uint64_t body = content.size() - kHeaderSize - kChecksumSize;
  // The sizes must match exactly; the divisions cannot overflow.
  const uint64_t stride = 4 * (uint64_t{1} + dim);
  if (dim > kMaxFeatureDim || body % stride != 0 || body / stride != count) {
    return BadInputError("the file is truncated or its header is damaged");
  }
  const size_t end = content.size() - kChecksumSize;
  if (XXH3_64bits(content.data(), end) != Take<uint64_t>(content, end)) {
    return BadInputError("the checksum does not match; the file is damaged");
  }
  Idsf idsf;
  idsf.feature_dim = static_cast<int>(dim);
  idsf.instances.resize(count);
  idsf.features.resize(count * dim);
  const char* data = content.data() + kHeaderSize;
  if (count > 0) {
    std::memcpy(idsf.instances.data(), data, 4 * count);
  }
  if (!idsf.features.empty()) {
    std::memcpy(
        idsf.features.data(), data + 4 * count, 4 * idsf.features.size());
  }
  for (const int32_t instance : idsf.instances) {
    if (instance < -1) return BadInputError("an instance index is below -1");
  }
  for (const float value : idsf.features) {
    if (!std::isfinite(value)) {
      return BadInputError("a semantic feature is not finite");
    }
  }
  return idsf;
}

StatusOr<Idsf> ReadIdsf(const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string content, ReadFile(path));
  StatusOr<Idsf> idsf = ParseIdsf(content);
  if (!idsf.ok()) return idsf.status().Annotated(path.string());
  return idsf;
}

}  // namespace freegs::semantics
