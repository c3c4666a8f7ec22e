// SPDX-License-Identifier: BSD-3-Clause
// Wholes and parts in a form that a page can walk: bootstrap/hierarchy.json
// without its thousands of merges.

#ifndef FREEGS_STAGES_VIEWER_VIEWER_LEVELS_H_
#define FREEGS_STAGES_VIEWER_VIEWER_LEVELS_H_

#include <cstdint>
#include <span>
#include <vector>

#include "semantics/instances/hierarchy.h"

namespace freegs::stages {

// A region of the hierarchy: the parts of ranks begin .. end - 1.
struct PartInterval {
  int32_t begin = 0;
  int32_t end = 0;

  friend bool operator==(const PartInterval&, const PartInterval&) = default;
};

struct InstanceLevels {
  // What semantics::RegionAround finds 1, 2, ... levels above the instance.
  std::vector<PartInterval> wider;

  // The regions below it, each once and before those inside it. Those that hold
  // a part, in this order, are what RegionAround finds 1, 2, ... levels below.
  // Left out are regions of fewer pixels than a tenth of a crumb, and a last
  // part that is hardly smaller than the level above it.
  std::vector<PartInterval> narrower;
};

struct ViewerLevels {
  // Ranks are such that the parts of every region have consecutive ones.
  std::vector<int32_t> rank_of_gaussian;  // -1 for Gaussians of no part.
  std::vector<InstanceLevels> of_label;
};

// labels: of each Gaussian, -1 .. num_labels - 1. The region of an instance is
// the one that most of its Gaussians are in where the hierarchy was cut. An
// instance without such Gaussians has no levels.
ViewerLevels MakeViewerLevels(const semantics::Hierarchy& hierarchy,
                              std::span<const int32_t> labels,
                              int num_labels);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEWER_VIEWER_LEVELS_H_
