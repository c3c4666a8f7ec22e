// SPDX-License-Identifier: BSD-3-Clause
// Whether photographs have colours of their own, as a search decided; see
// splat/search/exposure_search.h.

#ifndef FREEGS_SPLAT_TRAIN_EXPOSURE_CHOICE_H_
#define FREEGS_SPLAT_TRAIN_EXPOSURE_CHOICE_H_

namespace freegs::splat {

// The PSNR in dB on holdout photographs, with the colours as they are and
// fitted to each photograph (MeasureFittedHoldout).
struct HoldoutPsnr {
  double plain = 0;
  double fitted = 0;

  friend bool operator==(const HoldoutPsnr&, const HoldoutPsnr&) = default;
};

struct ExposureChoice {
  bool learn = false;

  // Of the two trials of the search.
  HoldoutPsnr without;
  HoldoutPsnr with;

  friend bool operator==(const ExposureChoice&,
                         const ExposureChoice&) = default;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TRAIN_EXPOSURE_CHOICE_H_
