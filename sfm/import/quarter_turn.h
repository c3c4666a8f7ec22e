// SPDX-License-Identifier: BSD-3-Clause
// Cameras and poses of pictures that are turned by right angles.

#ifndef FREEGS_SFM_IMPORT_QUARTER_TURN_H_
#define FREEGS_SFM_IMPORT_QUARTER_TURN_H_

#include "sfm/scene/camera.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// By how many right angles clockwise a stored photo is turned to be upright, if
// its EXIF orientation exchanges width and height without a mirror: 1 for 6, 3
// for 8. 0 for all others.
int QuarterTurns(int orientation);

// Makes the camera and the image, with its features, those of the picture that
// is turned by a right angle clockwise so many times. All camera models stay
// what they are. `camera` must pass Check().
void TurnClockwise(int quarter_turns, Camera* camera, PosedImage* image);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_IMPORT_QUARTER_TURN_H_
