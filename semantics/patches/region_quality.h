// SPDX-License-Identifier: BSD-3-Clause
// How likely each region of a tree is a whole thing: not a part of one, and not
// more than one.

#ifndef FREEGS_SEMANTICS_PATCHES_REGION_QUALITY_H_
#define FREEGS_SEMANTICS_PATCHES_REGION_QUALITY_H_

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"
#include "semantics/patches/evidence.h"
#include "semantics/patches/evidence_model.h"
#include "semantics/patches/region_graph.h"
#include "semantics/patches/region_merging.h"

namespace freegs::semantics {

// What is known of a region. Heights are log-odds of being two things, limited
// to 8. Crumbs, regions of hardly any pixels, do not count as parts or
// neighbours. "Parts" are the two regions that it was joined from, "neighbour"
// is the region that it is joined to, "outer" is what both become.
enum RegionAttribute : size_t {
  kPartsHeight,      // At which the parts were joined.
  kNeighbourHeight,  // At which it is joined to the neighbour.
  kWholeOdds,        // The probability that both heights alone give.
  kRegionSize,       // log10 of its share of all pixels.
  kNeighbourSize,    // log10 of the neighbour's pixels over its own.
  kOuterHeight,      // At which outer is joined to the next.
  kInnerHeight,      // The larger of those at which the parts were made.
  kLargestPart,      // Share of its pixels in the larger part.
  kOpenOutline,      // Share of its outline that meets no other region.
  kThinness,         // Thickness over width: 0 for a plane.
  kRoundness,        // Width over length: 0 for a line.
  kExtent,           // log10 of its length over that of the largest region.
  kRuggedness,       // log10 of the squared outline over the pixels.
  kColorSpread,      // Standard deviation of its colours.
  kNumOwnAttributes,
};

// Means over all pairs of pixels at which two patches meet.
enum ContactAttribute : size_t {
  kContactHidden,  // Share where one patch hides the other.
  kContactNear,    // Boundary in the photographs, narrow windows.
  kContactFar,     // Boundary in the photographs, wide windows.
  kContactColor,   // Difference of colours.
  kContactStep,    // Steps of depth.
  kContactRelief,  // Steps of planes fitted to both sides.
  kContactCrease,  // Concave above 0, convex below.
  kContactBend,    // Angle between the surfaces.
  kContactOdds,    // Log-odds that the two patches are of two things.
  kNumContactAttributes,
};

// All attributes of a region, in this order: those of RegionAttribute, those of
// ContactAttribute along its outline, those of ContactAttribute inside, the
// evidence between its parts, and the evidence between it and its neighbour.
// Semantics are not among the evidence.
inline constexpr size_t kFirstOutlineAttribute = kNumOwnAttributes;
inline constexpr size_t kFirstInsideAttribute =
    kFirstOutlineAttribute + kNumContactAttributes;
inline constexpr size_t kFirstPartsAttribute =
    kFirstInsideAttribute + kNumContactAttributes;
inline constexpr size_t kNumJoinAttributes = kSemantics;
inline constexpr size_t kFirstNeighbourAttribute =
    kFirstPartsAttribute + kNumJoinAttributes;
inline constexpr size_t kNumRegionAttributes =
    kFirstNeighbourAttribute + kNumJoinAttributes;
using RegionAttributes = std::array<float, kNumRegionAttributes>;

// The names of attributes in files: "parts_height", ..., "outline.hidden", ...,
// "inside.hidden", ..., "parts.contrast_near", ..., "neighbour.contrast_near",
// and so on. attribute: from 0 to kNumRegionAttributes - 1.
std::string RegionAttributeName(size_t attribute);

// Returns the attributes of every region of `tree`, which MergeRegions made of
// `graph` with `model`. of_contacts: what EvidenceOfContacts returns for
// `graph`. of_merges: the evidence of each merge of the tree. A crumb has less
// than min_size pixels.
std::vector<RegionAttributes> MeasureRegions(
    const RegionGraph& graph,
    std::span<const Evidence> of_contacts,
    const RegionTree& tree,
    std::span<const Evidence> of_merges,
    const EvidenceModel& model,
    double min_size);

// The tree that evidence leads to (MergeRegions), and the attributes of each
// region.
struct MeasuredTree {
  RegionTree tree;
  std::vector<RegionAttributes> attributes;
};
MeasuredTree MergeAndMeasure(const RegionGraph& graph,
                             std::span<const Evidence> of_contacts,
                             const EvidenceModel& evidence,
                             double min_size);

// A logistic regression. Values beyond what it was learnt from count like the
// least or the most of that, because photographs differ from drawings.
struct QualityModel {
  std::array<double, kNumRegionAttributes> least = {};
  std::array<double, kNumRegionAttributes> most = {};
  std::array<double, kNumRegionAttributes> weight = {};  // From least to most.
  double bias = 0;

  // Where a value of an attribute lies between its least and its most, from 0
  // to 1.
  double ShareOfRange(size_t attribute, double value) const;

  // The probability that the region is one whole thing.
  double Probability(const RegionAttributes& attributes) const;
};

// {"bias": -1, "numbers": [{"name": "parts_height", "least": -8, "most": 2,
//  "weight": 0.1}, ...]}: each attribute once, in any order. Further fields are
// ignored. kBadInput names the fault.
StatusOr<QualityModel> ParseQualityModel(std::string_view text);

// region_quality.json of this folder, which freegs_fit_evidence writes.
StatusOr<QualityModel> DefaultQualityModel();

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_REGION_QUALITY_H_
