// SPDX-License-Identifier: BSD-3-Clause

#ifndef FREEGS_TESTS_STAGES_WORD_FEATURES_H_
#define FREEGS_TESTS_STAGES_WORD_FEATURES_H_

#include <cstddef>
#include <filesystem>

#include <gtest/gtest.h>

#include "semantics/clip/opencv_clip.h"
#include "semantics/queries/instance_features.h"
#include "tests/semantics/clip/model_files.h"

namespace freegs::stages {

// Writes the features of three instances for TinyClip(): instance 1 means "red
// apple" exactly, 2 "wooden box"; of 3 nothing is known.
inline void WriteWordFeatures(const std::filesystem::path& file) {
  const auto encoder = semantics::OpenCvClip::Open(semantics::TinyClip());
  ASSERT_TRUE(encoder.ok()) << encoder.status().message();
  semantics::InstanceFeatures features;
  features.dim = (*encoder)->embedding_dim();
  features.model = semantics::TinyClip().string();
  features.model_hash = (*encoder)->model_hash();
  for (const char* text : {"red apple", "wooden box"}) {
    const auto vector = (*encoder)->EncodeText(text);
    ASSERT_TRUE(vector.ok());
    features.features.insert(
        features.features.end(), vector->values.begin(), vector->values.end());
  }
  features.features.resize(3 * static_cast<size_t>(features.dim));
  ASSERT_TRUE(semantics::WriteInstanceFeatures(file, features).ok());
}

}  // namespace freegs::stages

#endif  // FREEGS_TESTS_STAGES_WORD_FEATURES_H_
