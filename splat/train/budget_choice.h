// SPDX-License-Identifier: BSD-3-Clause
// The number of Gaussians and the SH degree that a search chose for a scene;
// see splat/search/budget_search.h.

#ifndef FREEGS_SPLAT_TRAIN_BUDGET_CHOICE_H_
#define FREEGS_SPLAT_TRAIN_BUDGET_CHOICE_H_

#include <cstdint>
#include <vector>

namespace freegs::splat {

// One training of the search. Its images were reduced, and `budget` is the
// number of Gaussians at that size.
struct BudgetTrial {
  int64_t budget = 0;
  int sh_degree = 0;
  double holdout_psnr = 0;  // In dB.

  friend bool operator==(const BudgetTrial&, const BudgetTrial&) = default;
};

struct BudgetChoice {
  int64_t budget = 0;  // At the full size of the images.
  int sh_degree = 0;
  std::vector<BudgetTrial> trials;  // In the order in which they were made.

  friend bool operator==(const BudgetChoice&, const BudgetChoice&) = default;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TRAIN_BUDGET_CHOICE_H_
