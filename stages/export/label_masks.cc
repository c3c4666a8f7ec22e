// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/label_masks.h"

#include <algorithm>

namespace freegs::stages {
namespace {

// Collects the runs of one label.
struct OpenMask {
  LabelMask mask;
  uint32_t end = 0;  // Where its last run ends.
};

// Pixels begin .. end - 1 of column x have the label. `height * x` of them lie
// in the columns before.
void AddPiece(
    uint32_t x, uint32_t begin, uint32_t end, uint32_t height, OpenMask* open) {
  LabelMask& mask = open->mask;
  const uint32_t from = x * height + begin;
  const uint32_t to = x * height + end;
  if (!mask.runs.empty() && from == open->end) {
    // It goes on from the foot of the column before.
    mask.runs.back() += to - from;
  } else {
    mask.runs.push_back(from - open->end);
    mask.runs.push_back(to - from);
  }
  open->end = to;
  if (mask.area == 0) {
    mask.left = static_cast<int>(x);
    mask.top = static_cast<int>(begin);
  }
  mask.area += to - from;
  mask.top = std::min(mask.top, static_cast<int>(begin));
  mask.bottom = std::max(mask.bottom, static_cast<int>(end));
  mask.right = static_cast<int>(x) + 1;
}

}  // namespace

std::map<int32_t, LabelMask> MasksOfLabels(const Image<int32_t>& labels) {
  const auto width = static_cast<uint32_t>(labels.width());
  const auto height = static_cast<uint32_t>(labels.height());
  std::map<int32_t, OpenMask> open;
  for (uint32_t x = 0; x < width; ++x) {
    const int32_t* const column = labels.data() + x;
    uint32_t begin = 0;
    for (uint32_t y = 1; y <= height; ++y) {
      const int32_t label = column[size_t{begin} * width];
      if (y < height && column[size_t{y} * width] == label) continue;
      if (label >= 0) AddPiece(x, begin, y, height, &open[label]);
      begin = y;
    }
  }
  std::map<int32_t, LabelMask> masks;
  for (auto& [label, opened] : open) {
    const uint32_t rest = width * height - opened.end;
    if (rest > 0) opened.mask.runs.push_back(rest);
    masks[label] = std::move(opened.mask);
  }
  return masks;
}

std::string CompressRuns(std::span<const uint32_t> runs) {
  std::string text;
  for (size_t i = 0; i < runs.size(); ++i) {
    int64_t value = runs[i];
    if (i > 2) value -= runs[i - 2];
    while (true) {
      const int64_t low = value & 31;
      value >>= 5;
      // Done when what is left is only the sign, which bit 4 repeats.
      const bool last = value == ((low & 16) != 0 ? -1 : 0);
      text.push_back(static_cast<char>('0' + low + (last ? 0 : 32)));
      if (last) break;
    }
  }
  return text;
}

}  // namespace freegs::stages
