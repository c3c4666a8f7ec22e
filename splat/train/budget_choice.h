// SPDX-License-Identifier: BSD-3-Clause
// How many Gaussians, and which SH degree, a search found a scene to need.

#ifndef FREEGS_SPLAT_TRAIN_BUDGET_CHOICE_H_
#define FREEGS_SPLAT_TRAIN_BUDGET_CHOICE_H_

#include <cstdint>
#include <vector>

namespace freegs::splat {

// One number of Gaussians and SH degree tried. The numbers are those of the
// level of the trial.
struct BudgetTrial {
  int64_t budget = 0;
  int sh_degree = 0;
  double holdout_psnr = 0;

  friend bool operator==(const BudgetTrial&, const BudgetTrial&) = default;
};

struct BudgetChoice {
  int64_t budget = 0;  // At full size.
  int sh_degree = 0;
  std::vector<BudgetTrial> trials;  // The evidence, in the order tried.

  friend bool operator==(const BudgetChoice&, const BudgetChoice&) = default;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TRAIN_BUDGET_CHOICE_H_
