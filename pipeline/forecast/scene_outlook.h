// SPDX-License-Identifier: BSD-3-Clause
// What is known of a scene, or foretold, before all of its stages have run.

#ifndef FREEGS_PIPELINE_FORECAST_SCENE_OUTLOOK_H_
#define FREEGS_PIPELINE_FORECAST_SCENE_OUTLOOK_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/pinhole.h"

namespace freegs::pipeline {

// The sizes that decide what a stage needs. The stages hand it on in their
// order (Stage::Foretell). A stage that is done writes into it what its files
// say, another one what it expects to make of what it is given. What is 0 or
// empty is not known.
struct SceneOutlook {
  // The photos as the stages before leave them. Only names, and the width and
  // height of the cameras, are set.
  std::vector<View> train;
  std::vector<View> holdout;

  int64_t photo_bytes = 0;  // Size of the photos' files.
  bool masks = false;       // Whether there are masks.
  // Sparse points that training starts from; 0 if not known.
  int64_t points = 0;
  // Gaussians of the trained model; 0 if not known.
  int64_t gaussians = 0;

  int64_t photos() const {
    return static_cast<int64_t>(train.size() + holdout.size());
  }
};

// Pixels of all views, and of the largest one, when their longest sides are
// limited to max_side (0: they are not).
struct ViewPixels {
  int64_t total = 0;
  int64_t largest = 0;
};
ViewPixels CountPixels(std::span<const View> views, int max_side);

// Counts the pixels of the views of training and of the holdout together.
ViewPixels CountPixels(const SceneOutlook& scene, int max_side);

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_FORECAST_SCENE_OUTLOOK_H_
