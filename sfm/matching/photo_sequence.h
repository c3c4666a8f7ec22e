// SPDX-License-Identifier: BSD-3-Clause
// Finds photos that were taken one after another, by the numbers in their
// names.

#ifndef FREEGS_SFM_MATCHING_PHOTO_SEQUENCE_H_
#define FREEGS_SFM_MATCHING_PHOTO_SEQUENCE_H_

#include <string>
#include <vector>

namespace freegs::sfm {

// Returns groups of photos whose names differ only in their numbers, such as
// "frame_0001.jpg" and "frame_0002.jpg". A group is a list of indices into
// `names`, ordered by the numbers; the leftmost number counts first. Groups of
// fewer than min_photos photos are left out. The largest group comes first, and
// of equally large ones that which begins with the smaller index.
std::vector<std::vector<int>> FindNumberedPhotos(
    const std::vector<std::string>& names, int min_photos);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MATCHING_PHOTO_SEQUENCE_H_
