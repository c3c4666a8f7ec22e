// SPDX-License-Identifier: BSD-3-Clause
// Parts, things and groups of things: the tree that instances are cut from. It
// answers what belongs to a thing as a whole, and what parts it has.

#ifndef FREEGS_SEMANTICS_INSTANCES_HIERARCHY_H_
#define FREEGS_SEMANTICS_INSTANCES_HIERARCHY_H_

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"
#include "semantics/patches/region_merging.h"

namespace freegs::semantics {

// Neighbouring levels (RegionAround) differ in size by this factor at least.
inline constexpr double kLevelRatio = 1.25;

// Crumbs, regions of fewer pixels than this, belong to what they were joined to
// or, if that is nothing, to nobody. total_pixels: see Hierarchy.
inline double CrumbSize(double total_pixels) { return 1e-3 * total_pixels; }

// Probabilities are kept to so many parts, so that files do not depend on the
// last digit of a processor's logarithm.
inline double RoundedQuality(double quality) {
  constexpr double kSteps = 1e4;
  return std::round(kSteps * quality) / kSteps;
}

struct Hierarchy {
  // Leaves are the smallest parts. A region is a leaf or a merge, numbered as
  // in RegionTree. Heights are log-odds of being two things.
  RegionTree tree;

  // How likely each region is a whole thing, from 0 to 1: one number for each
  // region.
  std::vector<double> quality;

  std::vector<double> part_pixels;  // Pixels of each leaf, in all photographs.
  double total_pixels = 0;          // Pixels of these photographs.

  // The leaf of each Gaussian, -1 for none.
  std::vector<int32_t> part_of_gaussian;

  double granularity = 0;  // Where the instances were cut.

  bool IsCrumb(double pixels) const {
    return !(pixels > 0 && pixels >= CrumbSize(total_pixels));
  }
};

// The regions from which the most whole things can be expected, where a thing
// counts by its share of all pixels to the power of 0.0625 * (1 - granularity).
// So at 0 large things count a little more than small ones, and larger numbers
// give more and smaller regions.
struct HierarchyCut {
  std::vector<int32_t> region_of_part;  // One for each leaf; -1 if hardly seen.
  // Labels 0 .. n - 1, by descending number of Gaussians; -1 for none.
  std::vector<int32_t> label_of_gaussian;
  std::vector<int32_t> region_of_label;
};
HierarchyCut CutHierarchy(const Hierarchy& hierarchy, double granularity);

// The region around a leaf that is `steps` levels above the one it is in at the
// hierarchy's own granularity, or below it for negative steps. Levels differ in
// size by a quarter at least. Ends at the root and at the leaf.
int32_t RegionAround(const Hierarchy& hierarchy, int32_t leaf, int steps);

// Makes one whole thing, which it is with the probability `quality`, of two
// regions of the hierarchy's own cut. The whole is the region around both if
// that is hardly larger (kLevelRatio) and holds hardly anything of others, and
// else a new region. The probability of each region inside is multiplied by
// 1 - quality. In the new cut the two are one region, and all other regions are
// as before, except for a few crumbs. Where this is not possible, returns false
// and changes nothing.
bool JoinAsWhole(int32_t a, int32_t b, double quality, Hierarchy* hierarchy);

// Returns for each Gaussian whether it is in `region`.
std::vector<uint8_t> GaussiansOf(const Hierarchy& hierarchy, int32_t region);

// {"granularity": 0, "total_pixels": 921600, "part_pixels": [12, ...],
//  "merges": [[a, b, height], ...], "quality": [0.5, ...],
//  "part_of_gaussian": [-1, 7, ...]}
std::string SerializeHierarchy(const Hierarchy& hierarchy);

// kBadInput, which names the fault, for malformed JSON, numbers out of range,
// merges of a region that is not there yet or merged already, and heights that
// descend.
StatusOr<Hierarchy> ParseHierarchy(std::string_view text);

Status WriteHierarchy(const std::filesystem::path& path,
                      const Hierarchy& hierarchy);

// kBadInput also if the file is of another number of Gaussians.
StatusOr<Hierarchy> ReadHierarchy(const std::filesystem::path& path,
                                  size_t num_gaussians);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_HIERARCHY_H_
