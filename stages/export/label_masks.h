// SPDX-License-Identifier: BSD-3-Clause
// The masks of a picture of labels as run lengths, in the two forms that COCO's
// tools read.

#ifndef FREEGS_STAGES_EXPORT_LABEL_MASKS_H_
#define FREEGS_STAGES_EXPORT_LABEL_MASKS_H_

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/image.h"

namespace freegs::stages {

// The pixels of one label.
struct LabelMask {
  // How many pixels in turn do not and do have the label, column after column,
  // from top to bottom in each. The first number, which may be 0, counts pixels
  // without the label. The numbers add up to width * height.
  std::vector<uint32_t> runs;

  int64_t area = 0;  // Pixels that have the label.

  // The smallest rectangle of pixels that holds them: columns left to right - 1
  // and rows top to bottom - 1.
  int left = 0;
  int top = 0;
  int right = 0;
  int bottom = 0;
};

// The masks of all labels of an H x W x 1 picture that are 0 or more, by label.
std::map<int32_t, LabelMask> MasksOfLabels(const Image<int32_t>& labels);

// The runs as COCO's compressed text. From the fourth number on, each is
// written as its difference from the number two places before. A number is
// written 5 bits at a time, the lowest first, as the characters from '0'; 32 is
// added to say that more follow, and the last one carries the sign.
std::string CompressRuns(std::span<const uint32_t> runs);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EXPORT_LABEL_MASKS_H_
