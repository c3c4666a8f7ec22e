// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/idsf.h"

#include <cmath>

#include "core/io/byte_stream.h"
#include "core/io/files.h"

namespace freegs::semantics {
namespace {

constexpr std::string_view kMagic = "FREEGSID";
constexpr uint32_t kVersion = 1;
constexpr size_t kHeaderSize = 8 + 4 + 4 + 8;
constexpr uint32_t kMaxFeatureDim = 1 << 16;

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
  ByteWriter writer;
  writer.Reserve(kHeaderSize + 4 * (count + idsf.features.size()) +
                 kChecksumBytes);
  writer.PutBytes(kMagic);
  writer.Put(kVersion);
  writer.Put(static_cast<uint32_t>(idsf.feature_dim));
  writer.Put(count);
  writer.PutArray(idsf.instances);
  writer.PutArray(idsf.features);
  writer.PutChecksum();
  return std::move(writer).content();
}

Status WriteIdsf(const std::filesystem::path& path, const Idsf& idsf) {
  FREEGS_ASSIGN_OR_RETURN(const std::string content, SerializeIdsf(idsf));
  return WriteFileAtomic(path, content);
}

StatusOr<Idsf> ParseIdsf(std::string_view content) {
  const Status not_idsf =
      BadInputError("this is not a semantic field (idsf.bin)");
  if (content.size() < kHeaderSize + kChecksumBytes) return not_idsf;
  ByteReader reader(WithoutChecksum(content));
  uint32_t version = 0;
  uint32_t dim = 0;
  uint64_t count = 0;
  if (!reader.SkipBytes(kMagic) || !reader.Get(&version)) return not_idsf;
  if (version != kVersion) {
    return BadInputError("version " + std::to_string(version) +
                         " of the file is not known; a newer program wrote it");
  }
  Idsf idsf;
  // Once `count` is known to fit, `count * dim` cannot overflow.
  if (!reader.Get(&dim) || dim > kMaxFeatureDim ||
      !reader.GetCount(4 * (size_t{1} + dim), &count) ||
      reader.remaining() != 4 * count * (uint64_t{1} + dim)) {
    return BadInputError("the file is truncated or its header is damaged");
  }
  if (!HasChecksum(content)) {
    return BadInputError("the checksum does not match; the file is damaged");
  }
  idsf.feature_dim = static_cast<int>(dim);
  // Cannot fail: the sizes match.
  reader.GetArray(count, &idsf.instances);
  reader.GetArray(count * dim, &idsf.features);
  for (const int32_t instance : idsf.instances) {
    if (instance < -1 ||
        (instance >= 0 && static_cast<uint64_t>(instance) >= count)) {
      return BadInputError("an instance index is " + std::to_string(instance) +
                           " and there are " + std::to_string(count) +
                           " Gaussians; it must be -1 or below that");
    }
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
