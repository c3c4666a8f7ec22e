// SPDX-License-Identifier: BSD-3-Clause
// Names of photos in the workspace.

#ifndef FREEGS_PHOTOS_PHOTO_NAMES_H_
#define FREEGS_PHOTOS_PHOTO_NAMES_H_

#include <vector>

#include "photos/photo_list.h"

namespace freegs::photos {

// Gives every usable photo its name in the workspace's photo folder. Photos
// that are not re-encoded keep their own names as far as possible. The names of
// re-encoded photos end in .png. A suffix that belongs to another format is
// replaced, because programs choose the format of what they write by the
// suffix. White space, control characters, backslashes, bytes that are not
// UTF-8 and a leading '#' become '_', because COLMAP's text files would split
// or skip such names, and a backslash is a slash to it. A name that is already
// taken gets a number; so does a folder that is called like a photo.
void AssignNames(std::vector<Photo>* photos);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_NAMES_H_
