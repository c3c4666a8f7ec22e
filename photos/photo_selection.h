// SPDX-License-Identifier: BSD-3-Clause
// Which of the usable photos are used, and for what.

#ifndef FREEGS_PHOTOS_PHOTO_SELECTION_H_
#define FREEGS_PHOTOS_PHOTO_SELECTION_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "photos/photo_list.h"

namespace freegs::photos {

// All functions here take photos in the order of the sequence and leave
// rejected ones as they are.

// Rejects photos whose content an earlier one has.
void RejectDuplicates(std::vector<Photo>* photos);

// Keeps about `fraction` (0..1] of the photos, at least three: the sharp ones,
// spread evenly over the sequence. Up to a half, the sequence is cut into as
// many windows as photos shall stay, and the sharpest of each window stays;
// above, into as many windows as photos shall go, and the blurriest of each
// goes. Rejects the others.
void RejectBlurred(double fraction, std::vector<Photo>* photos);

// Which photos are kept from training to measure the result.
struct HoldoutRule {
  // Photos 0, N, 2N, ... of the usable ones, as in 3D Gaussian Splatting (Kerbl
  // et al. 2023); 0 takes none. Only if nothing else is given below.
  int every = 8;

  // A shell pattern such as "test_*" or "val/*", matched with the whole name
  // relative to the photo folder and with the name without folders; or "none".
  std::string pattern = {};

  // Names, each either relative to the photo folder or without folders.
  // Replaces the rules above if not empty.
  std::vector<std::string> names = {};

  Status Check() const;
};

// The names in a text: one per line; empty lines, and lines that begin with
// '#', do not count.
std::vector<std::string> ParseNameList(const std::string& text);

// Sets the split of usable photos. kBadInput if fewer than two are left to
// train on. Names and patterns that match nothing come back, for a warning.
StatusOr<std::vector<std::string>> AssignHoldout(const HoldoutRule& rule,
                                                 std::vector<Photo>* photos);

// Numbers the groups of equal size, camera and focal length.
void AssignCameraGroups(std::vector<Photo>* photos);

// Gives every usable photo its name in the workspace's photo folder. Photos
// that are not re-encoded keep their own names as far as possible; re-encoded
// ones end in .png, and a suffix that belongs to another format is replaced,
// because programs choose the format of what they write by it. White space,
// control characters, bytes that are not UTF-8 and a leading '#' become '_':
// COLMAP's text files split or skip them. Names already taken get a number.
void AssignNames(std::vector<Photo>* photos);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_SELECTION_H_
