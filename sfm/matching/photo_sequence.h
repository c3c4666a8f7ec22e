// SPDX-License-Identifier: BSD-3-Clause
// Which photos were taken one after another, as far as their names tell.

#ifndef FREEGS_SFM_MATCHING_PHOTO_SEQUENCE_H_
#define FREEGS_SFM_MATCHING_PHOTO_SEQUENCE_H_

#include <string>
#include <vector>

namespace freegs::sfm {

// Groups of photos whose names differ in their numbers only, such as
// "frame_0001.jpg" and "frame_0002.jpg": indices into `names`, in the order of
// the numbers, the leftmost number first. Groups with fewer than min_photos are
// left out. The largest group comes first, of equals the one that begins with
// the smaller index.
std::vector<std::vector<int>> FindNumberedPhotos(
    const std::vector<std::string>& names, int min_photos);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MATCHING_PHOTO_SEQUENCE_H_
