// SPDX-License-Identifier: BSD-3-Clause
// Whether photographs have colours of their own, as a search decided; see
// splat/search/exposure_search.h.

#ifndef FREEGS_SPLAT_TRAIN_EXPOSURE_CHOICE_H_
#define FREEGS_SPLAT_TRAIN_EXPOSURE_CHOICE_H_

namespace freegs::splat {

// How well photographs look like the scene of a short training: mean PSNR in dB
// of the photographs that it was trained on, and of the right halves of the
// others. 0 where masks left nothing of them to measure, and where the short
// training failed.
struct TrialPsnr {
  double trained = 0;
  double held_out = 0;

  friend bool operator==(const TrialPsnr&, const TrialPsnr&) = default;
};

struct ExposureChoice {
  bool learn = false;

  // In the colours of the scene, and in those to expect of each photograph. For
  // photographs that were trained on these lie between what was learnt of the
  // photographs before and after (ExposureBetween). Those of the others are
  // fitted to the left half (MeasureFittedHoldout).
  TrialPsnr without;
  TrialPsnr with;

  friend bool operator==(const ExposureChoice&,
                         const ExposureChoice&) = default;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TRAIN_EXPOSURE_CHOICE_H_
