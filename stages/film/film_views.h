// SPDX-License-Identifier: BSD-3-Clause
// The views of a film of a workspace's scene, one per frame, all of one size.

#ifndef FREEGS_STAGES_FILM_FILM_VIEWS_H_
#define FREEGS_STAGES_FILM_FILM_VIEWS_H_

#include <cstddef>
#include <string>
#include <vector>

#include "core/pinhole.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::stages {

// The name of a frame, counted from 0: "frame_0001.png" is the first one.
std::string FrameName(size_t frame);

// All other functions return num_frames views with these names, whose width
// and height are even, as films need them: an odd last column or row is cut
// off. `photos` are the views of the photos, at the size that the film is to
// have; the camera is that of the first one. In the frame of the scene.

// The camera moves through the poses of the views, in their order.
std::vector<View> PathThrough(const std::vector<View>& views, int num_frames);

// The camera moves through the poses of the photos, in their order, smoothed as
// poses of a hand need it. Where the next photo was taken from quite another
// side, the camera goes around what it looks at, on the side that the photos
// saw, and not straight through it.
std::vector<View> PathOfPhotos(const std::vector<View>& photos, int num_frames);

// The camera circles the place that the photos look at, as far from it and as
// high above it as a typical photo. Where the photos leave more than a quarter
// of the circle unseen, it swings to and fro on the side that they saw.
std::vector<View> OrbitOfScene(const std::vector<View>& photos, int num_frames);

// The camera circles the Gaussians of `model`, an object that stands alone, at
// the distance at which they fill the picture.
std::vector<View> OrbitOfObject(const splat::GaussianModel& model,
                                const std::vector<View>& photos,
                                int num_frames);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_FILM_FILM_VIEWS_H_
