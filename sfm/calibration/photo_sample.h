// SPDX-License-Identifier: BSD-3-Clause
// A part of the photos of a reconstruction that sees the same points often.

#ifndef FREEGS_SFM_CALIBRATION_PHOTO_SAMPLE_H_
#define FREEGS_SFM_CALIBRATION_PHOTO_SAMPLE_H_

#include <cstddef>

#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// The model with at most `max_images` of its images, and with the points that
// at least two of these see. Images keep their order. A model that has no more
// images is returned as it is.
//
// Images are added one by one: the one with which most points that one to three
// images see already are seen once more. So the images overlap, and spread
// further once their points are seen by four. Every camera of the model gets
// three of its images first, as far as `max_images` allows.
//
// `model` must pass CheckReconstruction and must have no dangling references
// (see RemoveDanglingReferences). The result depends on nothing but `model` and
// `max_images`.
Reconstruction SamplePhotos(const Reconstruction& model, size_t max_images);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_CALIBRATION_PHOTO_SAMPLE_H_
