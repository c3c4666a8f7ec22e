// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/feature_cache.h"

#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <Eigen/Core>

#include "core/io/byte_stream.h"
#include "core/io/files.h"

namespace freegs::semantics {
namespace {

namespace fs = std::filesystem;

// The file, little-endian:
//   8 bytes   "FREEGSFC"
//   uint32    version, 1
//   uint32    width, height, channels
//   uint32    length of the key
//   bytes     key: what the features are of, to find files that were renamed
//   float16   height x width x channels features
//   uint64    XXH3 of everything before
constexpr std::string_view kEntryMagic = "FREEGSFC";
constexpr uint32_t kEntryVersion = 1;
constexpr size_t kEntryHeaderSize = 8 + 5 * 4;
constexpr uint32_t kMaxSide = 1 << 16;
constexpr uint64_t kMaxEntryBytes = uint64_t{1} << 32;

std::string KeyOf(const std::string& image_hash,
                  const std::string& model_hash,
                  const std::string& kind) {
  // Lengths first: no two different triples give the same key.
  return std::to_string(image_hash.size()) + " " +
         std::to_string(model_hash.size()) + " " + image_hash + " " +
         model_hash + " " + kind;
}

StatusOr<ImageF> ParseFeatures(std::string_view content, std::string_view key) {
  if (content.size() < kEntryHeaderSize + kChecksumBytes ||
      !content.starts_with(kEntryMagic)) {
    return BadInputError("not a file of features");
  }
  ByteReader reader(WithoutChecksum(content).substr(kEntryMagic.size()));
  uint32_t version = 0;
  uint32_t width = 0;
  uint32_t height = 0;
  uint32_t channels = 0;
  uint32_t key_size = 0;
  // Cannot fail: the header is there.
  reader.Get(&version);
  reader.Get(&width);
  reader.Get(&height);
  reader.Get(&channels);
  reader.Get(&key_size);
  if (version != kEntryVersion) {
    return BadInputError("written by another version of the program");
  }
  if (!HasChecksum(content)) return BadInputError("damaged or truncated");
  for (const uint32_t side : {width, height, channels}) {
    if (side == 0 || side > kMaxSide) return BadInputError("damaged header");
  }
  // No side is above 2^16, so the product of three is at most 2^48.
  const uint64_t values = uint64_t{width} * height * channels;
  if (reader.remaining() != key_size + 2 * values) {
    return BadInputError("damaged header");
  }
  if (key_size != key.size() || !reader.SkipBytes(key)) {
    return BadInputError("features of another image or model");
  }
  ImageF features(static_cast<int>(width),
                  static_cast<int>(height),
                  static_cast<int>(channels));
  for (uint64_t i = 0; i < values; ++i) {
    uint16_t bits = 0;
    reader.Get(&bits);
    features.data()[i] =
        static_cast<float>(Eigen::numext::bit_cast<Eigen::half>(bits));
    if (!std::isfinite(features.data()[i])) {
      return BadInputError("features that are not finite");
    }
  }
  return features;
}

// WriteFileAtomic for a file that another run may write at the same time. Each
// writer has a temporary file of its own, so that none takes away that of
// another. The last one to finish replaces what is there.
Status WriteAmongOthers(const fs::path& path, std::string_view content) {
  std::string own = path.string() + ".XXXXXX";
  const int descriptor = mkstemp(own.data());
  if (descriptor < 0) {
    return InternalError(own + ": cannot write: " + std::strerror(errno));
  }
  close(descriptor);
  Status status = WriteFileAtomic(own, content);
  std::error_code error;
  if (status.ok()) {
    fs::rename(own, path, error);
    if (!error) return Status();
    status =
        InternalError(path.string() + ": cannot replace: " + error.message());
  }
  fs::remove(own, error);
  return status;
}

}  // namespace

FeatureCache::FeatureCache(fs::path folder) : folder_(std::move(folder)) {}

fs::path FeatureCache::FileOf(const std::string& image_hash,
                              const std::string& model_hash,
                              const std::string& kind) const {
  // A hash: whatever the key's text, the name stays in the folder.
  return folder_ /
         (HashBytes(KeyOf(image_hash, model_hash, kind)) + ".features");
}

CachedFeatures FeatureCache::Find(const std::string& image_hash,
                                  const std::string& model_hash,
                                  const std::string& kind) const {
  const fs::path path = FileOf(image_hash, model_hash, kind);
  std::error_code error;
  if (!fs::exists(path, error)) return {std::nullopt, "not kept yet"};
  const StatusOr<std::string> content = ReadFile(path, kMaxEntryBytes);
  if (!content.ok()) return {std::nullopt, content.status().message()};
  StatusOr<ImageF> features =
      ParseFeatures(*content, KeyOf(image_hash, model_hash, kind));
  if (!features.ok()) {
    return {std::nullopt, path.string() + ": " + features.status().message()};
  }
  return {*std::move(features), ""};
}

Status FeatureCache::Store(const std::string& image_hash,
                           const std::string& model_hash,
                           const std::string& kind,
                           const ImageF& features) const {
  const std::string key = KeyOf(image_hash, model_hash, kind);
  if (features.empty()) {
    return InvalidArgumentError("there are no features to keep");
  }
  ByteWriter writer;
  writer.Reserve(kEntryHeaderSize + key.size() + 2 * features.size() +
                 kChecksumBytes);
  writer.PutBytes(kEntryMagic);
  writer.Put(kEntryVersion);
  writer.Put(static_cast<uint32_t>(features.width()));
  writer.Put(static_cast<uint32_t>(features.height()));
  writer.Put(static_cast<uint32_t>(features.channels()));
  writer.Put(static_cast<uint32_t>(key.size()));
  writer.PutBytes(key);
  for (size_t i = 0; i < features.size(); ++i) {
    const auto value = static_cast<Eigen::half>(features.data()[i]);
    if (!std::isfinite(static_cast<float>(value))) {
      return InvalidArgumentError("feature " + std::to_string(i) +
                                  " is not a number of half precision");
    }
    writer.Put(Eigen::numext::bit_cast<uint16_t>(value));
  }
  writer.PutChecksum();
  FREEGS_RETURN_IF_ERROR(CreateFolders(folder_));
  return WriteAmongOthers(FileOf(image_hash, model_hash, kind),
                          writer.content());
}

StatusOr<ImageF> EncodeDenseCached(ClipEncoder& encoder,
                                   const FeatureCache& cache,
                                   const std::string& image_hash,
                                   const ImageU8& image,
                                   int dense_size) {
  if (dense_size == 0) dense_size = encoder.dense_sizes().front();
  const std::string kind = "dense " + std::to_string(dense_size);
  CachedFeatures cached = cache.Find(image_hash, encoder.model_hash(), kind);
  if (cached.features) return *std::move(cached.features);
  FREEGS_ASSIGN_OR_RETURN(ImageF features,
                          encoder.EncodeDense(image, dense_size));
  FREEGS_RETURN_IF_ERROR(
      cache.Store(image_hash, encoder.model_hash(), kind, features));
  for (size_t i = 0; i < features.size(); ++i) {
    features.data()[i] =
        static_cast<float>(static_cast<Eigen::half>(features.data()[i]));
  }
  return features;
}

}  // namespace freegs::semantics
