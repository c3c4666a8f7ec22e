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
enum RegionNumber : size_t {
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
  kNumOwnNumbers,
};

// Means over all pairs of pixels at which two patches meet.
enum ContactNumber : size_t {
  kContactHidden,  // Share where one patch hides the other.
  kContactNear,    // Boundary in the photographs, narrow windows.
  kContactFar,     // The same, wide windows.
  kContactColor,   // Difference of colours.
  kContactStep,    // Steps of depth.
  kContactRelief,  // The same, of planes fitted to both sides.
  kContactCrease,  // Concave above 0, convex below.
  kContactBend,    // Angle between the surfaces.
  kContactOdds,    // Log-odds that the two patches are of two things.
  kNumContactNumbers,
};

// The numbers of RegionNumber, those of the region's outline, those of what is
// inside, the evidence between the parts, and that between the region and its
// neighbour. Semantics are not among the evidence.
inline constexpr size_t kFirstOutlineNumber = kNumOwnNumbers;
inline constexpr size_t kFirstInsideNumber =
    kFirstOutlineNumber + kNumContactNumbers;
inline constexpr size_t kFirstPartsNumber =
    kFirstInsideNumber + kNumContactNumbers;
inline constexpr size_t kNumJoinNumbers = kSemantics;
inline constexpr size_t kFirstNeighbourNumber =
    kFirstPartsNumber + kNumJoinNumbers;
inline constexpr size_t kNumRegionNumbers =
    kFirstNeighbourNumber + kNumJoinNumbers;
using RegionNumbers = std::array<float, kNumRegionNumbers>;

// "parts_height", ..., "outline.hidden", ..., "inside.hidden", ...,
// "parts.contrast_near", ..., "neighbour.contrast_near".
std::string RegionNumberName(size_t number);

// Of every region of the tree that MergeRegions made of the graph with the
// model, with the evidence of each merge. of_contacts: EvidenceOfContacts. A
// crumb has less than min_size pixels.
std::vector<RegionNumbers> MeasureRegions(const RegionGraph& graph,
                                          std::span<const Evidence> of_contacts,
                                          const RegionTree& tree,
                                          std::span<const Evidence> of_merges,
                                          const EvidenceModel& model,
                                          double min_size);

// The tree that evidence leads to (MergeRegions), and the numbers of each
// region.
struct MeasuredTree {
  RegionTree tree;
  std::vector<RegionNumbers> numbers;
};
MeasuredTree MergeAndMeasure(const RegionGraph& graph,
                             std::span<const Evidence> of_contacts,
                             const EvidenceModel& evidence,
                             double min_size);

// A logistic regression. Numbers beyond what it was learnt from count like the
// least or the most of that, because photographs differ from drawings.
struct QualityModel {
  std::array<double, kNumRegionNumbers> least = {};
  std::array<double, kNumRegionNumbers> most = {};
  std::array<double, kNumRegionNumbers> weight = {};  // From least to most.
  double bias = 0;

  // Where a value of a number lies between least and most: from 0 to 1.
  double ShareOfRange(size_t number, double value) const;

  // Of being a whole thing, from 0 to 1.
  double Probability(const RegionNumbers& numbers) const;
};

// {"bias": -1, "numbers": [{"name": "parts_height", "least": -8, "most": 2,
//  "weight": 0.1}, ...]}: each number once, in any order. Further fields are
// ignored. kBadInput names the fault.
StatusOr<QualityModel> ParseQualityModel(std::string_view text);

// region_quality.json of this folder, which freegs_fit_evidence writes.
StatusOr<QualityModel> DefaultQualityModel();

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_REGION_QUALITY_H_
