// SPDX-License-Identifier: BSD-3-Clause
// Draws a scene: colour with soft shadows and antialiasing, and the truth of
// each pixel.

#ifndef FREEGS_TESTS_SCENE_MAKER_RAY_CASTER_H_
#define FREEGS_TESTS_SCENE_MAKER_RAY_CASTER_H_

#include "core/image.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "tests/scene_maker/scene.h"

namespace freegs::scene_maker {

struct Photo {
  ImageU8 color;  // H x W x 3, sRGB.
  // These come from a single ray through the centre of each pixel.
  ImageU16 instances;   // Object id, 0 = background.
  ImageU16 background;  // 1 + index into kBackgroundClasses, 0 = object.
  ImageU16 surfaces;    // Object id, or 200 + Solid::surface.
  ImageF depth;         // z of the camera frame, metres.
};

// Added to the number of a surface that is no object.
inline constexpr int kFirstSurface = 200;

// Draws the photo of a view. It has the same bytes for any number of threads.
Photo CastRays(const Scene& scene, const View& view, ThreadPool& pool);

}  // namespace freegs::scene_maker

#endif  // FREEGS_TESTS_SCENE_MAKER_RAY_CASTER_H_
