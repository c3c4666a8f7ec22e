// SPDX-License-Identifier: BSD-3-Clause
// What is done to photographs or to camera poses, to see what the program makes
// of it: "noise:8", "drop:0.3", "jitter:2".

#ifndef FREEGS_STAGES_DISTURB_DISTURBANCE_H_
#define FREEGS_STAGES_DISTURB_DISTURBANCE_H_

#include <string>

#include "core/status.h"

namespace freegs::stages {

enum class DisturbanceKind {
  kNone,

  // The pixels of each photograph.
  kNoise,         // Normal noise; amount: its standard deviation, of 255.
  kBlur,          // Gaussian blur; amount: its standard deviation in pixels.
  kJpeg,          // Compressed anew; amount: the quality, 1 to 100.
  kExposure,      // From dark to bright over the photographs; amount: the stops
                  // from the first to the last.
  kWhiteBalance,  // From blue to red over the photographs; amount: the stops by
                  // which the ratio of red to blue grows from first to last.
  kTexture,       // Details within surfaces fade; amount: how much of their
                  // contrast goes, 0 to 1.
  kMover,         // A spotted thing lies somewhere else in each photograph;
                  // amount: its diameter as a share of the shorter side.

  // Which photographs there are, and what their files say.
  kDrop,     // Photographs are missing; amount: which share.
  kViews,    // Neighbours only; amount: how many photographs.
  kShuffle,  // In another order; without an amount.
  kFocal,    // EXIF gives a focal length; amount: times what EXIF said before,
             // or times the longest side where it said nothing.

  // Camera poses and points.
  kJitter,  // Each camera is turned; amount: by how many pixels the centre of
            // the picture moves, standard deviation in x and in y.
  kScale,   // Another unit of length; amount: times.
  kMove,    // Another origin; amount: how far, in units of the model.
};

struct Disturbance {
  DisturbanceKind kind = DisturbanceKind::kNone;
  double amount = 0;

  // Whether camera poses are disturbed, and not photographs.
  bool ChangesPoses() const;

  bool operator==(const Disturbance&) const = default;
};

// Reads "none", "shuffle" or "NAME:AMOUNT". kInvalidArgument says which there
// are, or which amounts make sense.
StatusOr<Disturbance> ParseDisturbance(const std::string& text);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_DISTURB_DISTURBANCE_H_
