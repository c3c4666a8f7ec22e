// SPDX-License-Identifier: BSD-3-Clause
// The 2D-3D joint contrastive loss (FreeGS eq. 9): features of one instance
// come together, on Gaussians and on pixels, and those of others move away.

#ifndef FREEGS_SEMANTICS_LOSSES_JOINT_CONTRASTIVE_LOSS_H_
#define FREEGS_SEMANTICS_LOSSES_JOINT_CONTRASTIVE_LOSS_H_

#include <cstdint>
#include <span>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

struct ContrastiveOptions {
  double temperature = 0.1;  // tau
  // Groups whose means have a cosine above this are positives of each other:
  // fragments of one thing, that may merge when next clustered.
  double positive_cosine = 0.96;

  Status Check() const;
};

// Features of Gaussians or of pixels, and the groups that they belong to.
struct ContrastiveMembers {
  std::span<const float> features;  // M x D, row-major.
  std::span<const int32_t> groups;  // M; negative: of no group, left out.
  std::span<float> gradients;       // M x D; what is added to.
};

// Returns L = mean over groups i of the mean over members j of i of l_j, l_j as
// the form says, and adds weight dL/df to the gradients of both.
//
// The mean feature of a group is over its members of both kinds, here given;
// the group itself is a positive of its own. Without negatives (one group, or
// all alike) l_j is 0. Groups whose mean, and members whose feature, is of
// length 0 (below 1e-12) have no direction and do not count. 0 for no members.
//
// Means are held constant in the derivative, as class prototypes are: they
// follow their members by themselves, and a member is not moved for the sake of
// how others stand to its mean. Equation 9 sums over members; the mean keeps
// the balance of groups, and of the losses, free of their sizes and of how many
// members are sampled.
//
// kInvalidArgument for sizes that disagree, features that are not finite and
// more than 4096 groups; then the gradients are as before.
StatusOr<double> JointContrastiveLoss(const ContrastiveOptions& options,
                                      int dim,
                                      const ContrastiveMembers& gaussians,
                                      const ContrastiveMembers& pixels,
                                      double weight,
                                      ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_JOINT_CONTRASTIVE_LOSS_H_
