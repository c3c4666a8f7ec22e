// SPDX-License-Identifier: BSD-3-Clause
// Keeps dense features of images on disk, so that a network sees each image
// only once.

#ifndef FREEGS_SEMANTICS_CLIP_FEATURE_CACHE_H_
#define FREEGS_SEMANTICS_CLIP_FEATURE_CACHE_H_

#include <filesystem>
#include <optional>
#include <string>

#include "core/image.h"
#include "core/status.h"
#include "semantics/clip/clip_encoder.h"

namespace freegs::semantics {

struct CachedFeatures {
  std::optional<ImageF> features;

  // If there are none: why, in words. The features were never stored, or the
  // file is damaged or holds something else, which counts as not stored.
  std::string reason;
};

// One file per image, model and kind of features, in half precision. Files are
// written completely or not at all. Several models may share a folder, and
// several runs may use it at the same time. Files of models that are no longer
// used stay until somebody removes the folder.
class FeatureCache {
 public:
  // The folder is created when features are stored for the first time.
  explicit FeatureCache(std::filesystem::path folder);

  // image_hash and model_hash identify image and model by their content
  // (HashFile() of core/io/files.h, ClipEncoder::model_hash()). kind says what
  // was computed, for example "dense 224". Each may be any text. There are no
  // errors, only missing features.
  CachedFeatures Find(const std::string& image_hash,
                      const std::string& model_hash,
                      const std::string& kind) const;

  // Stores features, rounded to half precision. kInvalidArgument if they are
  // empty or hold values that half precision cannot (beyond 65504, or not
  // finite); kInternal if the file cannot be written.
  Status Store(const std::string& image_hash,
               const std::string& model_hash,
               const std::string& kind,
               const ImageF& features) const;

  // The file in which Find() looks.
  std::filesystem::path FileOf(const std::string& image_hash,
                               const std::string& model_hash,
                               const std::string& kind) const;

 private:
  const std::filesystem::path folder_;
};

// Returns encoder.EncodeDense(image, dense_size) from the cache, or computes
// and stores it. image_hash identifies `image`. The result is rounded to half
// precision in both cases, so that it does not depend on what the cache holds.
StatusOr<ImageF> EncodeDenseCached(ClipEncoder& encoder,
                                   const FeatureCache& cache,
                                   const std::string& image_hash,
                                   const ImageU8& image,
                                   int dense_size = 0);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_FEATURE_CACHE_H_
