// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/feature_cache.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <system_error>
#include <utility>

#include <Eigen/Core>
#include <xxhash.h>

#include "core/io/files.h"

namespace freegs::semantics {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little,
              "numbers are copied to little-endian files as they are");

// The file, little-endian:
//   8 bytes   "FREEGSFC"
//   uint32    version, 1
//   uint32    width, height, channels
//   uint32    length of the key
//   bytes     key: what the features are of, to find files that were renamed
//   float16   height x width x channels features
//   uint64    XXH3 of everything before
constexpr std::string_view kMagic = "FREEGSFC";
constexpr uint32_t kVersion = 1;
constexpr size_t kHeaderSize = 8 + 5 * 4;
constexpr size_t kChecksumSize = 8;
constexpr uint32_t kMaxSide = 1 << 16;
constexpr uint64_t kMaxFileBytes = uint64_t{1} << 32;

std::string KeyOf(const std::string& image_hash,
                  const std::string& model_hash,
                  const std::string& kind) {
  // Lengths first: no two different triples give the same key.
  return std::to_string(image_hash.size()) + " " +
         std::to_string(model_hash.size()) + " " + image_hash + " " +
         model_hash + " " + kind;
}

template <typename T>
void Append(const T& value, std::string* content) {
  content->append(reinterpret_cast<const char*>(&value), sizeof(T));
}

template <typename T>
T Take(std::string_view content, size_t offset) {
  T value;
  std::memcpy(&value, content.data() + offset, sizeof(T));
  return value;
}

StatusOr<ImageF> ParseFeatures(std::string_view content, std::string_view key) {
  if (content.size() < kHeaderSize + kChecksumSize ||
      !content.starts_with(kMagic)) {
    return BadInputError("not a file of features");
  }
  if (Take<uint32_t>(content, 8) != kVersion) {
    return BadInputError("written by another version of the program");
  }
  const size_t end = content.size() - kChecksumSize;
  if (XXH3_64bits(content.data(), end) != Take<uint64_t>(content, end)) {
    return BadInputError("damaged or truncated");
  }
  const auto width = Take<uint32_t>(content, 12);
  const auto height = Take<uint32_t>(content, 16);
  const auto channels = Take<uint32_t>(content, 20);
  const auto key_size = Take<uint32_t>(content, 24);
  const uint64_t body = end - kHeaderSize;
  for (const uint32_t side : {width, height, channels}) {
    if (side == 0 || side > kMaxSide) return BadInputError("damaged header");
  }
  // Of three sides up to 2^16 the product is below 2^48.
  const uint64_t values = uint64_t{width} * height * channels;
  if (key_size > body || body - key_size != 2 * values) {
    return BadInputError("damaged header");
  }
  if (content.substr(kHeaderSize, key_size) != key) {
    return BadInputError("features of another image or model");
  }
  ImageF features(static_cast<int>(width),
                  static_cast<int>(height),
                  static_cast<int>(channels));
  const char* data = content.data() + kHeaderSize + key_size;
  for (uint64_t i = 0; i < values; ++i) {
    Eigen::half value;
    std::memcpy(&value, data + 2 * i, 2);
    features.data()[i] = static_cast<float>(value);
    if (!std::isfinite(features.data()[i])) {
      return BadInputError("features that are not finite");
    }
  }
  return features;
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
  const StatusOr<std::string> content = ReadFile(path, kMaxFileBytes);
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
  std::string content(kMagic);
  content.reserve(kHeaderSize + key.size() + 2 * features.size() +
                  kChecksumSize);
  Append(kVersion, &content);
  Append(static_cast<uint32_t>(features.width()), &content);
  Append(static_cast<uint32_t>(features.height()), &content);
  Append(static_cast<uint32_t>(features.channels()), &content);
  Append(static_cast<uint32_t>(key.size()), &content);
  content += key;
  for (size_t i = 0; i < features.size(); ++i) {
    const auto value = static_cast<Eigen::half>(features.data()[i]);
    if (!std::isfinite(static_cast<float>(value))) {
      return InvalidArgumentError("feature " + std::to_string(i) +
                                  " is not a number of half precision");
    }
    Append(value, &content);
  }
  Append(static_cast<uint64_t>(XXH3_64bits(content.data(), content.size())),
         &content);
  FREEGS_RETURN_IF_ERROR(CreateFolders(folder_));
  return WriteFileAtomic(FileOf(image_hash, model_hash, kind), content);
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
