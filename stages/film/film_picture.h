// SPDX-License-Identifier: BSD-3-Clause
// The pictures of a film: the scene as a colour picture, whatever it shows.

#ifndef FREEGS_STAGES_FILM_FILM_PICTURE_H_
#define FREEGS_STAGES_FILM_FILM_PICTURE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "stages/scene/depth_image.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

// What the pictures show, and what they need for it.
struct FilmContent {
  // "color", "depth" (bright is near), "instances" (in their colours),
  // "semantics", or "both": colour on the left, instances on the right.
  std::string what = "color";

  std::vector<int32_t> labels;         // Per Gaussian; instances and both.
  std::vector<float> semantic_colors;  // N x 3; semantics.
  DepthRange depth_range;              // In units of the scene's frame; depth.
};

// Returns H x W x 3 RGB of the view's size; with "both" it is twice as wide.
ImageU8 FilmPicture(const WorkspaceScene& scene,
                    const FilmContent& content,
                    const View& view,
                    ThreadPool& pool);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_FILM_FILM_PICTURE_H_
