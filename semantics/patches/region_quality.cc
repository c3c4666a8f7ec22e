// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/region_quality.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <nlohmann/json.hpp>

#include "semantics/patches/logistic_model_json.h"
#include "semantics/patches/region_quality_json.h"

namespace freegs::semantics {
namespace {

constexpr double kMaxHeight = 8;

constexpr std::array<const char*, kNumOwnAttributes> kOwnNames = {
    "parts_height",
    "neighbour_height",
    "whole_odds",
    "size",
    "neighbour_size",
    "outer_height",
    "inner_height",
    "largest_part",
    "open_outline",
    "thinness",
    "roundness",
    "extent",
    "ruggedness",
    "color_spread"};

constexpr std::array<const char*, kNumContactAttributes> kContactNames = {
    "hidden",
    "contrast_near",
    "contrast_far",
    "color",
    "depth_step",
    "relief",
    "crease",
    "bend",
    "odds"};

double Logistic(double x) { return 1 / (1 + std::exp(-x)); }

double Ratio(double a, double b) { return b > 0 ? a / b : 0; }

// The joins of a tree as if its crumbs were not there. All are by region.
struct Joins {
  static constexpr int32_t kNone = -1;

  std::vector<int32_t> made_by;    // The merge of its parts.
  std::vector<int32_t> joined_by;  // The merge with its neighbour.
  std::vector<int32_t> neighbour;  // A region.
  std::vector<int32_t> parent;     // In the tree, crumbs included.
  std::vector<double> inner;       // RegionAttribute kInnerHeight.
  std::vector<double> largest_part;
};

// The height of a merge, limited to kMaxHeight; `none` if `merge` is kNone.
double HeightOf(const RegionTree& tree, int32_t merge, double none) {
  return merge == Joins::kNone
             ? none
             : std::clamp(tree.merges[merge].height, -kMaxHeight, kMaxHeight);
}

Joins FindJoins(const RegionTree& tree,
                const std::vector<double>& sizes,
                double min_size) {
  const auto num_regions = static_cast<int32_t>(sizes.size());
  const auto is_crumb = [&](int32_t r) { return sizes[r] < min_size; };
  Joins joins;
  joins.made_by.assign(sizes.size(), Joins::kNone);
  joins.joined_by = joins.neighbour = joins.parent = joins.made_by;
  joins.inner.assign(sizes.size(), -kMaxHeight);
  joins.largest_part.assign(sizes.size(), 1.0);
  for (int32_t r = tree.num_leaves; r < num_regions; ++r) {
    const auto k = r - tree.num_leaves;
    const auto [a, b, height] = tree.merges[k];
    joins.parent[a] = joins.parent[b] = r;
    const double from_a = HeightOf(tree, joins.made_by[a], -kMaxHeight);
    const double from_b = HeightOf(tree, joins.made_by[b], -kMaxHeight);
    if (is_crumb(a) || is_crumb(b)) {
      joins.made_by[r] = joins.made_by[from_b > from_a ? b : a];
      const int32_t larger = sizes[b] > sizes[a] ? b : a;
      joins.inner[r] = joins.inner[larger];
      joins.largest_part[r] = joins.largest_part[larger];
    } else {
      joins.made_by[r] = k;
      joins.inner[r] = std::max(from_a, from_b);
      joins.largest_part[r] = Ratio(std::max(sizes[a], sizes[b]), sizes[r]);
    }
  }
  for (int32_t r = num_regions; r-- > tree.num_leaves;) {
    const auto k = r - tree.num_leaves;
    const auto [a, b, height] = tree.merges[k];
    for (const auto& [one, other] : {std::pair(a, b), std::pair(b, a)}) {
      const bool alone = is_crumb(other);
      joins.joined_by[one] = alone ? joins.joined_by[r] : k;
      joins.neighbour[one] = alone ? joins.neighbour[r] : other;
    }
  }
  return joins;
}

// Contacts of patches, added up.
struct Contacts {
  ContactStats stats;
  double odds = 0;  // Sum of the log-odds that a pair is of two things.

  double pairs() const { return stats.pixels + stats.hidden; }
  void Add(const Contacts& other) {
    stats.Add(other.stats);
    odds += other.odds;
  }
};

// By region: all contacts across its outline, and all inside.
struct RegionContacts {
  std::vector<Contacts> outline;
  std::vector<Contacts> inside;
};

RegionContacts SortContacts(const RegionGraph& graph,
                            std::span<const Evidence> of_contacts,
                            const EvidenceModel& model,
                            const std::vector<int32_t>& parent) {
  RegionContacts sorted;
  sorted.outline.resize(parent.size());
  sorted.inside.resize(parent.size());
  for (size_t k = 0; k < graph.contacts.size(); ++k) {
    const Contact& contact = graph.contacts[k];
    Contacts one;
    one.stats = contact.stats;
    one.odds = one.pairs() * model.Difference(of_contacts[k]);
    // From both sides up to the region that has both. A parent has a larger
    // number than its parts, so the smaller of two numbers goes up first.
    int32_t a = contact.a;
    int32_t b = contact.b;
    while (a != b) {
      if (b < 0 || (a >= 0 && a < b)) std::swap(a, b);
      sorted.outline[b].Add(one);
      b = parent[b];
    }
    if (a >= 0) sorted.inside[a].Add(one);
  }
  for (size_t r = 0; r < parent.size(); ++r) {
    if (parent[r] >= 0) sorted.inside[parent[r]].Add(sorted.inside[r]);
  }
  return sorted;
}

void SetContacts(const Contacts& contacts,
                 size_t first,
                 RegionAttributes* attributes) {
  const ContactStats& stats = contacts.stats;
  const double seen = stats.pixels;
  const double all = contacts.pairs();
  const auto set = [&](ContactAttribute attribute, double value) {
    (*attributes)[first + attribute] = static_cast<float>(value);
  };
  set(kContactHidden, Ratio(stats.hidden, all));
  set(kContactNear, Ratio(stats.contrast_near, seen));
  set(kContactFar, Ratio(stats.contrast_far, seen));
  set(kContactColor, Ratio(stats.difference, seen));
  set(kContactStep, Ratio(stats.depth_step, seen));
  set(kContactRelief, Ratio(stats.relief, all));
  set(kContactCrease, Ratio(stats.concavity, seen));
  set(kContactBend, Ratio(stats.bend, seen));
  set(kContactOdds, Ratio(contacts.odds, all));
}

// The height at which the first region around r that is larger is joined.
double OuterHeight(const RegionTree& tree,
                   const Joins& joins,
                   const std::vector<double>& sizes,
                   int32_t r) {
  constexpr double kLarger = 1.02;
  int32_t outer = joins.parent[r];
  while (outer >= 0 && sizes[outer] < kLarger * sizes[r]) {
    outer = joins.parent[outer];
  }
  return outer < 0 ? kMaxHeight
                   : HeightOf(tree, joins.joined_by[outer], kMaxHeight);
}

void CopyEvidence(std::span<const Evidence> evidence,
                  int32_t merge,
                  size_t first,
                  RegionAttributes* attributes) {
  if (merge == Joins::kNone) return;
  std::copy_n(evidence[merge].begin(),
              kNumJoinAttributes,
              attributes->begin() + static_cast<std::ptrdiff_t>(first));
}

}  // namespace

std::string RegionAttributeName(size_t attribute) {
  if (attribute < kFirstOutlineAttribute) return kOwnNames[attribute];
  if (attribute < kFirstInsideAttribute) {
    return std::string("outline.") +
           kContactNames[attribute - kFirstOutlineAttribute];
  }
  if (attribute < kFirstPartsAttribute) {
    return std::string("inside.") +
           kContactNames[attribute - kFirstInsideAttribute];
  }
  if (attribute < kFirstNeighbourAttribute) {
    return std::string("parts.") +
           kEvidenceNames[attribute - kFirstPartsAttribute];
  }
  return std::string("neighbour.") +
         kEvidenceNames[attribute - kFirstNeighbourAttribute];
}

std::vector<RegionAttributes> MeasureRegions(
    const RegionGraph& graph,
    std::span<const Evidence> of_contacts,
    const RegionTree& tree,
    std::span<const Evidence> of_merges,
    const EvidenceModel& model,
    double min_size) {
  std::vector<RegionStats> regions = graph.regions;
  for (const RegionTree::Merge& merge : tree.merges) {
    regions.push_back(regions[merge.a]);
    regions.back().Add(regions[merge.b]);
  }
  std::vector<double> sizes;
  for (const RegionStats& region : regions) sizes.push_back(region.pixels);
  const Joins joins = FindJoins(tree, sizes, min_size);
  const RegionContacts contacts =
      SortContacts(graph, of_contacts, model, joins.parent);
  std::vector<RegionExtent> extents;
  for (const RegionStats& region : regions) {
    extents.push_back(ExtentOf(region));
  }
  const auto largest = std::ranges::max_element(sizes) - sizes.begin();
  std::vector<RegionAttributes> all(regions.size());
  for (size_t r = 0; r < regions.size(); ++r) {
    RegionAttributes& attributes = all[r];
    const auto set = [&attributes](RegionAttribute attribute, double value) {
      attributes[attribute] = static_cast<float>(value);
    };
    const double pixels = std::max(1.0, sizes[r]);
    const double parts = HeightOf(tree, joins.made_by[r], -kMaxHeight);
    const double next = HeightOf(tree, joins.joined_by[r], kMaxHeight);
    set(kPartsHeight, parts);
    set(kNeighbourHeight, next);
    set(kWholeOdds, Logistic(-parts) * Logistic(next));
    set(kRegionSize, std::log10(pixels / std::max(1.0, graph.total_pixels)));
    const int32_t neighbour = joins.neighbour[r];
    constexpr double kNoNeighbour = 3;
    set(kNeighbourSize,
        neighbour < 0 ? kNoNeighbour
                      : std::log10(std::max(1.0, sizes[neighbour]) / pixels));
    set(kOuterHeight, OuterHeight(tree, joins, sizes, static_cast<int32_t>(r)));
    set(kInnerHeight, joins.inner[r]);
    set(kLargestPart, joins.largest_part[r]);
    // The outlines of its patches, without what lies inside.
    const double outline =
        std::max(1.0, regions[r].perimeter - 2 * contacts.inside[r].pairs());
    set(kOpenOutline, 1 - std::min(1.0, contacts.outline[r].pairs() / outline));
    const RegionExtent& extent = extents[r];
    set(kThinness, extent.Flatness());
    set(kRoundness, Ratio(extent.width, extent.length));
    constexpr double kLeastLength = 1e-9;
    set(kExtent,
        std::log10(std::max(kLeastLength, extent.length) /
                   std::max(kLeastLength, extents[largest].length)));
    set(kRuggedness, std::log10(outline * outline / pixels));
    const Eigen::Vector3d mean = regions[r].color / pixels;
    set(kColorSpread,
        std::sqrt(std::max(
            0.0, (regions[r].color2 / pixels - mean.cwiseAbs2()).sum())));
    SetContacts(contacts.outline[r], kFirstOutlineAttribute, &attributes);
    SetContacts(contacts.inside[r], kFirstInsideAttribute, &attributes);
    CopyEvidence(
        of_merges, joins.made_by[r], kFirstPartsAttribute, &attributes);
    CopyEvidence(
        of_merges, joins.joined_by[r], kFirstNeighbourAttribute, &attributes);
  }
  return all;
}

MeasuredTree MergeAndMeasure(const RegionGraph& graph,
                             std::span<const Evidence> of_contacts,
                             const EvidenceModel& evidence,
                             double min_size) {
  MeasuredTree measured;
  std::vector<Evidence> of_merge;
  measured.tree = MergeRegions(
      graph,
      of_contacts,
      [&](const Evidence& e) { return evidence.Difference(e); },
      [&](int32_t, int32_t, const Evidence& e) {
        of_merge.push_back(e);
        return true;
      });
  measured.attributes = MeasureRegions(
      graph, of_contacts, measured.tree, of_merge, evidence, min_size);
  return measured;
}

double QualityModel::ShareOfRange(size_t attribute, double value) const {
  const double range = most[attribute] - least[attribute];
  if (!(range > 0)) return 0;
  return (std::clamp(value, least[attribute], most[attribute]) -
          least[attribute]) /
         range;
}

double QualityModel::Probability(const RegionAttributes& attributes) const {
  double sum = bias;
  for (size_t k = 0; k < kNumRegionAttributes; ++k) {
    sum += weight[k] * ShareOfRange(k, attributes[k]);
  }
  return Logistic(sum);
}

StatusOr<QualityModel> ParseQualityModel(std::string_view text) {
  LogisticModelFormat format = {.source = "region quality", .list = "numbers"};
  for (size_t k = 0; k < kNumRegionAttributes; ++k) {
    format.names.push_back(RegionAttributeName(k));
  }
  QualityModel model;
  const auto read_row = [&](size_t k, const nlohmann::json& row) -> Status {
    const std::string& name = format.names[k];
    FREEGS_ASSIGN_OR_RETURN(model.least[k],
                            ReadModelNumber(row, name, "least"));
    FREEGS_ASSIGN_OR_RETURN(model.most[k], ReadModelNumber(row, name, "most"));
    FREEGS_ASSIGN_OR_RETURN(model.weight[k],
                            ReadModelNumber(row, name, "weight"));
    if (model.most[k] >= model.least[k]) return Status();
    return BadInputError(format.source + ": " + name +
                         ": most is less than least");
  };
  FREEGS_ASSIGN_OR_RETURN(model.bias,
                          ParseLogisticModel(text, format, read_row));
  return model;
}

StatusOr<QualityModel> DefaultQualityModel() {
  return ParseQualityModel(kRegionQualityJson);
}

}  // namespace freegs::semantics
