// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/forecast/scene_outlook.h"

#include <algorithm>

namespace freegs::pipeline {

ViewPixels CountPixels(std::span<const View> views, int max_side) {
  ViewPixels pixels;
  for (const View& view : views) {
    const Pinhole camera = view.camera.LimitedTo(max_side);
    const int64_t count = int64_t{camera.width} * camera.height;
    pixels.total += count;
    pixels.largest = std::max(pixels.largest, count);
  }
  return pixels;
}

ViewPixels CountPixels(const SceneOutlook& scene, int max_side) {
  const ViewPixels train = CountPixels(scene.train, max_side);
  const ViewPixels holdout = CountPixels(scene.holdout, max_side);
  return {train.total + holdout.total,
          std::max(train.largest, holdout.largest)};
}

}  // namespace freegs::pipeline
