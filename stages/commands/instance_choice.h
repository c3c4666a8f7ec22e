// SPDX-License-Identifier: BSD-3-Clause
// --only 3,17 and --without 3,17: which instances a command works on.

#ifndef FREEGS_STAGES_COMMANDS_INSTANCE_CHOICE_H_
#define FREEGS_STAGES_COMMANDS_INSTANCE_CHOICE_H_

#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/status.h"

namespace freegs::stages {

struct InstanceChoice {
  // Lists of ids such as "3,17", of which one at least is empty.
  std::string only = {};
  std::string without = {};

  bool everything() const { return only.empty() && without.empty(); }
};

// The functions below return kInvalidArgument, which names the option, for
// texts that are no lists of ids, for ids that no Gaussian has, and when both
// options are given. `labels` has one label per Gaussian (id - 1, or -1).

// The labels of the instances that are chosen, without -1.
StatusOr<std::set<int32_t>> ChosenLabels(const InstanceChoice& choice,
                                         std::span<const int32_t> labels);

// The Gaussians that are chosen, in ascending order. Those of no instance are
// among them only with --without.
StatusOr<std::vector<uint32_t>> ChosenGaussians(
    const InstanceChoice& choice, std::span<const int32_t> labels);

// Only whether the texts are lists of ids, and not both are given.
Status CheckInstanceChoice(const InstanceChoice& choice);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_INSTANCE_CHOICE_H_
