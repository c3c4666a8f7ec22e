// SPDX-License-Identifier: BSD-3-Clause
// The 2D-3D joint contrastive loss (FreeGS eq. 8). It draws together the
// features of one instance, on Gaussians and on pixels, and drives apart those
// of different instances.

#ifndef FREEGS_SEMANTICS_LOSSES_JOINT_CONTRASTIVE_LOSS_H_
#define FREEGS_SEMANTICS_LOSSES_JOINT_CONTRASTIVE_LOSS_H_

#include <cstdint>
#include <span>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

struct ContrastiveOptions {
  double temperature = 0.1;  // tau
  // Groups whose mean features have a larger cosine are positives of each
  // other: they may be fragments of one thing that merge in the next
  // clustering.
  double positive_cosine = 0.96;

  Status Check() const;
};

// Features of Gaussians or of pixels, and the groups to which they belong.
struct ContrastiveMembers {
  std::span<const float> features;  // M x D, row-major.
  // M; members of negative groups do not count.
  std::span<const int32_t> groups;
  std::span<float> gradients;  // M x D; gradients are added to it.
};

// Returns L, the mean over groups of the mean over their members of l, and adds
// weight dL/df to the gradients of both kinds of members. For a member with
// feature f let P and N be the sums of exp(cos(f, m) / tau) over the mean
// features m of the positive and of the negative groups. Then
//   l = -log(P / (P + N)) >= 0,
// as in InfoNCE (van den Oord et al. 2018). Eq. 8 is printed as -log(P / N).
// That form falls below zero to about -2 / tau, and drives members on with full
// strength when they are well placed already.
//
// The mean feature of a group is over its members of both kinds. A group is a
// positive of itself. Without negatives l is 0. Members whose feature has no
// length (below 1e-12) do not count, and neither do groups whose mean has none.
// L is 0 for no members.
//
// The means are constants in the derivative, like class prototypes. Eq. 8 sums
// over members; the mean makes the weight of a group independent of how many of
// its members were sampled.
//
// kInvalidArgument for sizes that disagree, features that are not finite and
// more than 4096 groups; then the gradients are unchanged.
StatusOr<double> JointContrastiveLoss(const ContrastiveOptions& options,
                                      int dim,
                                      const ContrastiveMembers& gaussians,
                                      const ContrastiveMembers& pixels,
                                      double weight,
                                      ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_JOINT_CONTRASTIVE_LOSS_H_
