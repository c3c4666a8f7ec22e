// SPDX-License-Identifier: BSD-3-Clause
// Scenes for tests of forecasts.

#ifndef FREEGS_TESTS_STAGES_SCENE_OUTLOOK_OF_H_
#define FREEGS_TESTS_STAGES_SCENE_OUTLOOK_OF_H_

#include <string>

#include "pipeline/forecast/scene_outlook.h"

namespace freegs::stages {

// So many photos of one size, every 8th held out, 5000 points and 50000
// Gaussians.
inline pipeline::SceneOutlook SceneOutlookOf(int photos,
                                             int width,
                                             int height) {
  pipeline::SceneOutlook scene;
  for (int i = 0; i < photos; ++i) {
    View view;
    view.name = std::to_string(i) + ".jpg";
    view.camera.width = width;
    view.camera.height = height;
    (i % 8 == 0 ? scene.holdout : scene.train).push_back(view);
  }
  scene.photo_bytes = int64_t{width} * height * photos / 4;
  scene.points = 5000;
  scene.gaussians = 50000;
  return scene;
}

}  // namespace freegs::stages

#endif  // FREEGS_TESTS_STAGES_SCENE_OUTLOOK_OF_H_
