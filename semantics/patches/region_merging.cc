// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/region_merging.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <set>
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
               const DifferenceFn& difference,
               const AllowFn& allow)
      : difference_(difference),
        allow_(allow),
        total_pixels_(graph.total_pixels),
        regions_(std::move(graph.regions)),
        contacts_(regions_.size()),
        alive_(regions_.size(), true) {
    tree_.num_leaves = static_cast<int>(regions_.size());
    for (const Contact& contact : graph.contacts) {
      contacts_[contact.a][contact.b] = contact.stats;
      contacts_[contact.b][contact.a] = contact.stats;
      Offer(contact.a, contact.b, contact.stats);
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
    return MeasureEvidence(regions_[a], regions_[b], contact, total_pixels_);
  }

  void Offer(int32_t a, int32_t b, const ContactStats& contact) {
    const double difference = difference_(EvidenceOf(a, b, contact));
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
      Offer(joined, other, contact);
    }
    contacts_.push_back(std::move(contacts));
  }

  const DifferenceFn& difference_;
  const AllowFn& allow_;
  const double total_pixels_;
  std::vector<RegionStats> regions_;
  std::vector<std::map<int32_t, ContactStats>> contacts_;
  std::vector<bool> alive_;
  std::priority_queue<Candidate> queue_;
  RegionTree tree_;
};

}  // namespace

std::vector<int32_t> RegionTree::Cut(double height) const {
  std::vector<int32_t> parent(num_leaves + merges.size(), -1);
  for (size_t k = 0; k < merges.size(); ++k) {
    if (merges[k].height > height) break;
    const auto joined = static_cast<int32_t>(num_leaves + k);
    parent[merges[k].a] = joined;
    parent[merges[k].b] = joined;
  }
  // Parents have larger numbers than their parts.
  std::vector<int32_t> top(parent.size());
  for (size_t k = parent.size(); k-- > 0;) {
    top[k] = parent[k] < 0 ? static_cast<int32_t>(k) : top[parent[k]];
  }
  top.resize(num_leaves);
  return top;
}

RegionTree MergeRegions(RegionGraph graph,
                        const DifferenceFn& difference,
                        const AllowFn& allow) {
  return RegionMerger(std::move(graph), difference, allow).Run();
}

std::vector<int32_t> AbsorbSmallRegions(
    const RegionGraph& graph,
    const std::vector<int32_t>& region_of_patch,
    const DifferenceFn& difference,
    double min_pixels) {
  // Regions as patches of a graph of their own.
  std::map<int32_t, int32_t> number;
  std::vector<int32_t> region(region_of_patch.size());
  for (size_t p = 0; p < region.size(); ++p) {
    region[p] = number
                    .try_emplace(region_of_patch[p],
                                 static_cast<int32_t>(number.size()))
                    .first->second;
  }
  std::vector<RegionStats> regions(number.size());
  for (size_t p = 0; p < region.size(); ++p) {
    regions[region[p]].Add(graph.regions[p]);
  }
  std::vector<std::map<int32_t, ContactStats>> contacts(regions.size());
  for (const Contact& contact : graph.contacts) {
    const int32_t a = region[contact.a];
    const int32_t b = region[contact.b];
    if (a == b) continue;
    contacts[a][b].Add(contact.stats);
    contacts[b][a].Add(contact.stats);
  }
  std::vector<int32_t> into(regions.size());
  std::set<std::pair<double, int32_t>> small;
  for (int32_t r = 0; r < static_cast<int32_t>(regions.size()); ++r) {
    into[r] = r;
    if (regions[r].pixels < min_pixels) small.insert({regions[r].pixels, r});
  }
  while (!small.empty()) {
    const int32_t r = small.begin()->second;
    small.erase(small.begin());
    double least = std::numeric_limits<double>::infinity();
    int32_t best = -1;
    for (const auto& [other, contact] : contacts[r]) {
      const double d = difference(MeasureEvidence(
          regions[r], regions[other], contact, graph.total_pixels));
      if (d < least) {
        least = d;
        best = other;
      }
    }
    if (best < 0) continue;
    if (regions[best].pixels < min_pixels) {
      small.erase({regions[best].pixels, best});
    }
    regions[best].Add(regions[r]);
    const ContactStats& inner = contacts[r][best];
    regions[best].perimeter -= 2 * (inner.pixels + inner.hidden);
    if (regions[best].pixels < min_pixels) {
      small.insert({regions[best].pixels, best});
    }
    for (const auto& [other, contact] : contacts[r]) {
      contacts[other].erase(r);
      if (other == best) continue;
      contacts[best][other].Add(contact);
      contacts[other][best].Add(contact);
    }
    contacts[r].clear();
    into[r] = best;
  }
  for (int32_t& r : region) {
    while (into[r] != r) r = into[r];
  }
  std::map<int32_t, int32_t> left;
  for (int32_t& r : region) {
    r = left.try_emplace(r, static_cast<int32_t>(left.size())).first->second;
  }
  return region;
}

}  // namespace freegs::semantics
