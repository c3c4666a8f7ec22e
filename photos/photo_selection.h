// SPDX-License-Identifier: BSD-3-Clause
// Decides which photos are used, and which of them are kept from training.

#ifndef FREEGS_PHOTOS_PHOTO_SELECTION_H_
#define FREEGS_PHOTOS_PHOTO_SELECTION_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "photos/photo_list.h"

namespace freegs::photos {

// All functions here take the photos in the order in which they were taken, and
// leave photos that are already rejected as they are.

// Among photos that have the same content, keeps the one with the shortest
// name, such as "a.jpg" and not "copy of a.jpg", and rejects the others. Among
// equally long names the first in the alphabet stays.
void RejectDuplicates(std::vector<Photo>* photos);

// Keeps about the share `fraction`, in (0, 1], of the photos, but at least
// three, and rejects the others. The photos that stay are sharp and spread
// evenly over the sequence. For a fraction up to 0.5 the sequence is cut into
// as many windows as photos shall stay, and the sharpest photo of each window
// stays. For a larger fraction it is cut into as many windows as photos shall
// go, and the blurriest photo of each window goes.
void RejectBlurred(double fraction, std::vector<Photo>* photos);

// Which photos are kept from training to measure the result.
struct HoldoutRule {
  // Takes photos 0, N, 2N, ... of the usable ones, as 3D Gaussian Splatting
  // does (Kerbl et al. 2023); 0 takes none. It counts only if `pattern` and
  // `names` are empty.
  int every = 8;

  // A shell pattern such as "test_*" or "val/*". It may match the name relative
  // to the photo folder or the name without folders. "none" takes no photo.
  std::string pattern = {};

  // Names of photos, either relative to the photo folder or without folders:
  // Photo::file, or Photo::name, or a file without its suffix if that means one
  // photo only. If there are any, they replace the rules above.
  std::vector<std::string> names = {};

  Status Check() const;
};

// Returns the names in a text, one per line, without white space around them
// and without a leading "./". Empty lines and lines that begin with '#' do not
// count.
std::vector<std::string> ParseNameList(const std::string& text);

// Sets the split of the usable photos. Returns those names and patterns that
// match no usable photo, so that the caller can warn. Returns kBadInput if
// there are names and none of them means a photo, usable or not, and if fewer
// than two photos are left for training.
StatusOr<std::vector<std::string>> AssignHoldout(const HoldoutRule& rule,
                                                 std::vector<Photo>* photos);

// Sets camera_group: photos of equal size, camera and focal length get the same
// number. Frames of different films get different ones, and so do photos of
// different folders whose EXIF names no camera, where there are ten or more.
void AssignCameraGroups(std::vector<Photo>* photos);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_SELECTION_H_
