// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/region_merging.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <tuple>
#include <utility>

namespace freegs::semantics {
namespace {

struct Candidate {
  double difference = 0;
  int32_t a = 0;
  int32_t b = 0;

  // The best comes out of a std::priority_queue first.
  friend bool operator<(const Candidate& x, const Candidate& y) {
    return std::tie(x.difference, x.a, x.b) > std::tie(y.difference, y.a, y.b);
  }
};

class RegionMerger {
 public:
  RegionMerger(RegionGraph graph,
               std::span<const Evidence> of_contacts,
               const DifferenceFn& difference,
               const AllowFn& allow)
      : difference_(difference),
        allow_(allow),
        total_pixels_(graph.total_pixels),
        regions_(std::move(graph.regions)),
        contacts_(regions_.size()),
        alive_(regions_.size(), true) {
    tree_.num_leaves = static_cast<int>(regions_.size());
    for (const RegionStats& region : regions_) {
      extents_.push_back(ExtentOf(region));
    }
    for (size_t k = 0; k < graph.contacts.size(); ++k) {
      const auto& [a, b, stats] = graph.contacts[k];
      contacts_[a][b] = stats;
      contacts_[b][a] = stats;
      Offer(a, b, of_contacts[k]);
    }
  }

  RegionTree Run() {
    double height = -std::numeric_limits<double>::infinity();
    while (!queue_.empty()) {
      const Candidate best = queue_.top();
      queue_.pop();
      // A region that was joined has another number since.
      if (!alive_[best.a] || !alive_[best.b]) continue;
      if (allow_ &&
          !allow_(best.a,
                  best.b,
                  EvidenceOf(best.a, best.b, contacts_[best.a][best.b]))) {
        continue;
      }
      height = std::max(height, best.difference);
      tree_.merges.push_back({best.a, best.b, height});
      Join(best.a, best.b);
    }
    return std::move(tree_);
  }

 private:
  Evidence EvidenceOf(int32_t a, int32_t b, const ContactStats& contact) const {
    return MeasureEvidence({regions_[a], extents_[a]},
                           {regions_[b], extents_[b]},
                           contact,
                           total_pixels_);
  }

  void Offer(int32_t a, int32_t b, const Evidence& evidence) {
    const double difference = difference_(evidence);
    // What is not a number has no place in the order.
    if (std::isnan(difference)) return;
    queue_.push({difference, std::min(a, b), std::max(a, b)});
  }

  void Join(int32_t a, int32_t b) {
    const auto joined = static_cast<int32_t>(regions_.size());
    RegionStats region = std::move(regions_[a]);
    region.Add(regions_[b]);
    const ContactStats& inner = contacts_[a][b];
    region.perimeter -= 2 * (inner.pixels + inner.hidden);
    extents_.push_back(ExtentOf(region));
    regions_.push_back(std::move(region));
    alive_[a] = alive_[b] = false;
    alive_.push_back(true);
    std::map<int32_t, ContactStats> contacts = std::move(contacts_[a]);
    contacts.erase(b);
    for (const auto& [other, contact] : contacts_[b]) {
      if (other != a) contacts[other].Add(contact);
    }
    contacts_[b].clear();
    contacts_[a].clear();
    for (const auto& [other, contact] : contacts) {
      contacts_[other].erase(a);
      contacts_[other].erase(b);
      contacts_[other][joined] = contact;
      Offer(joined, other, EvidenceOf(joined, other, contact));
    }
    contacts_.push_back(std::move(contacts));
  }

  const DifferenceFn& difference_;
  const AllowFn& allow_;
  const double total_pixels_;
  std::vector<RegionStats> regions_;
  std::vector<RegionExtent> extents_;
  std::vector<std::map<int32_t, ContactStats>> contacts_;
  std::vector<bool> alive_;
  std::priority_queue<Candidate> queue_;
  RegionTree tree_;
};

// For each region, whether it is worth as much as the best of what it falls
// into. See RegionTree::MostWorth.
std::vector<uint8_t> AreWhole(const RegionTree& tree,
                              std::span<const double> worth,
                              const std::vector<double>& sizes,
                              double min_size) {
  // The largest sum within each region.
  std::vector<double> best(sizes.size(), 0.0);
  std::vector<uint8_t> is_whole(sizes.size());
  for (size_t r = 0; r < sizes.size(); ++r) {
    const double whole = sizes[r] < min_size ? 0 : worth[r];
    const auto num_leaves = static_cast<size_t>(tree.num_leaves);
    if (r < num_leaves) {
      is_whole[r] = 1;  // There is nothing that it could fall into.
      best[r] = whole;
      continue;
    }
    const RegionTree::Merge& merge = tree.merges[r - num_leaves];
    const double parts = best[merge.a] + best[merge.b];
    is_whole[r] = whole >= parts ? 1 : 0;
    best[r] = std::max(whole, parts);
  }
  return is_whole;
}

}  // namespace

std::vector<double> RegionTree::Sums(std::span<const double> of_leaves) const {
  std::vector<double> sums(of_leaves.begin(), of_leaves.end());
  for (const Merge& merge : merges) {
    sums.push_back(sums[merge.a] + sums[merge.b]);
  }
  return sums;
}

std::vector<int32_t> RegionTree::Cut(double height) const {
  const auto num_regions = static_cast<int32_t>(num_leaves + merges.size());
  std::vector<int32_t> top(num_regions, -1);
  for (int32_t r = num_regions; r-- > 0;) {
    if (top[r] < 0) top[r] = r;
    if (r < num_leaves) continue;
    const Merge& merge = merges[r - num_leaves];
    if (merge.height <= height) top[merge.a] = top[merge.b] = top[r];
  }
  top.resize(num_leaves);
  return top;
}

std::vector<int32_t> RegionTree::MostWorth(std::span<const double> worth,
                                           std::span<const double> leaf_sizes,
                                           double min_size) const {
  const std::vector<double> sizes = Sums(leaf_sizes);
  const auto num_regions = static_cast<int32_t>(sizes.size());
  const std::vector<uint8_t> is_whole = AreWhole(*this, worth, sizes, min_size);
  // The whole thing that the largest part of each region is in or has.
  std::vector<int32_t> main(num_regions);
  for (int32_t r = 0; r < num_regions; ++r) {
    main[r] = r;
    if (is_whole[r] != 0) continue;
    const Merge& merge = merges[r - num_leaves];
    main[r] = main[sizes[merge.a] < sizes[merge.b] ? merge.b : merge.a];
  }
  // From the root down; -1 for what falls into more than one.
  std::vector<int32_t> top(num_regions, -1);
  for (int32_t r = num_regions; r-- > 0;) {
    if (top[r] < 0 && is_whole[r] != 0) top[r] = r;
    if (r < num_leaves) continue;
    const Merge& merge = merges[r - num_leaves];
    if (top[r] >= 0) {
      top[merge.a] = top[merge.b] = top[r];
      continue;
    }
    const bool b_is_smaller = sizes[merge.b] <= sizes[merge.a];
    const int32_t smaller = b_is_smaller ? merge.b : merge.a;
    if (sizes[smaller] < min_size) {
      top[smaller] = main[b_is_smaller ? merge.a : merge.b];
    }
  }
  top.resize(num_leaves);
  return top;
}

RegionTree MergeRegions(RegionGraph graph,
                        const DifferenceFn& difference,
                        const AllowFn& allow) {
  const std::vector<Evidence> of_contacts = EvidenceOfContacts(graph);
  return MergeRegions(std::move(graph), of_contacts, difference, allow);
}

RegionTree MergeRegions(RegionGraph graph,
                        std::span<const Evidence> of_contacts,
                        const DifferenceFn& difference,
                        const AllowFn& allow) {
  return RegionMerger(std::move(graph), of_contacts, difference, allow).Run();
}

}  // namespace freegs::semantics
