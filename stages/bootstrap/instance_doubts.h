// SPDX-License-Identifier: BSD-3-Clause
// What speaks against the instances that were found.

#ifndef FREEGS_STAGES_BOOTSTRAP_INSTANCE_DOUBTS_H_
#define FREEGS_STAGES_BOOTSTRAP_INSTANCE_DOUBTS_H_

#include <string>
#include <vector>

#include "semantics/instances/instance_clustering.h"

namespace freegs::stages {

// The mean of the instances' scores, 0 without instances.
double MeanScore(const semantics::InstanceLabels& labels);

// Warnings for the user: too few instances to be the things of a scene, or
// instances that are hardly likely to be whole things. union_space: they were
// found by bootstrap.clustering `union`, whose scores say something else.
std::vector<std::string> DoubtsAbout(const semantics::InstanceLabels& labels,
                                     bool union_space);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BOOTSTRAP_INSTANCE_DOUBTS_H_
