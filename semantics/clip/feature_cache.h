// SPDX-License-Identifier: BSD-3-Clause
// Dense features of images on disk, so that a network sees each image once.

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

  // Why there are none, for people: not kept yet, or a file that is damaged or
  // of something else, which counts as not kept.
  std::string reason;
};

// One file per image, model and kind of features, in half precision. Files are
// written whole or not at all. A folder may serve any number of models; what a
// model left behind stays until somebody removes the folder.
class FeatureCache {
 public:
  // The folder is made when something is kept.
  explicit FeatureCache(std::filesystem::path folder);

  // image_hash and model_hash say by content what image and model are (HashFile
  // of core/io/files.h, ClipEncoder::model_hash()); kind says what was computed,
  // such as "dense 224". Any text will do. Never fails: it has no features.
  CachedFeatures Find(const std::string& image_hash,
                      const std::string& model_hash,
                      const std::string& kind) const;

  // Keeps features rounded to half precision. kInvalidArgument if they are
  // empty or not numbers of half precision, up to 65504; kInternal if the file
  // cannot be written.
  Status Store(const std::string& image_hash,
               const std::string& model_hash,
               const std::string& kind,
               const ImageF& features) const;

  // Where Find looks.
  std::filesystem::path FileOf(const std::string& image_hash,
                               const std::string& model_hash,
                               const std::string& kind) const;

 private:
  const std::filesystem::path folder_;
};

// encoder.EncodeDense by way of the cache. `image` is what image_hash names; it
// is looked at only if the features are not kept yet. The result is rounded to
// half precision either way: it does not depend on what the cache holds.
StatusOr<ImageF> EncodeDenseCached(ClipEncoder& encoder,
                                   const FeatureCache& cache,
                                   const std::string& image_hash,
                                   const ImageU8& image,
                                   int dense_size = 0);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_FEATURE_CACHE_H_
