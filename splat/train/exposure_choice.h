// SPDX-License-Identifier: BSD-3-Clause
// Whether photographs have colours of their own, as a search decided; see
// splat/search/exposure_search.h.

#ifndef FREEGS_SPLAT_TRAIN_EXPOSURE_CHOICE_H_
#define FREEGS_SPLAT_TRAIN_EXPOSURE_CHOICE_H_

namespace freegs::splat {

struct ExposureChoice {
  bool learn = false;

  // The PSNR in dB of the two trials of the search.
  double psnr_without = 0;
  double psnr_with = 0;

  friend bool operator==(const ExposureChoice&,
                         const ExposureChoice&) = default;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TRAIN_EXPOSURE_CHOICE_H_
