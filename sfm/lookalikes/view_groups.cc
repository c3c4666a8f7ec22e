// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/lookalikes/view_groups.h"

#include <algorithm>
#include <map>
#include <set>

#include "sfm/matching/match_database.h"

namespace freegs::sfm {
namespace {

// With less evidence than this against them, two groups hold together, whatever
// supports them.
constexpr double kMinAgainst = 30;
constexpr size_t kMinPhotos = 4;

struct Evidence {
  double supporting = 0;
  double against = 0;

  void Add(const Evidence& other) {
    supporting += other.supporting;
    against += other.against;
  }
  double surplus() const {
    return (1 - kMinSupport) * supporting - kMinSupport * against;
  }
  double share() const { return supporting / (supporting + against); }
  bool HoldsTogether() const { return surplus() > 0 || against < kMinAgainst; }
  bool IsStronger(const Evidence& other) const {
    return std::pair(HoldsTogether(), surplus()) >
           std::pair(other.HoldsTogether(), other.surplus());
  }
};

// Groups of photos, by the least id of each, and the evidence between them.
class Contraction {
 public:
  explicit Contraction(const std::vector<PairSupport>& pairs) {
    for (const PairSupport& pair : pairs) {
      members_[pair.image_id1] = {pair.image_id1};
      members_[pair.image_id2] = {pair.image_id2};
      Connect(pair.image_id1, pair.image_id2, {pair.supporting, pair.against});
    }
  }

  // Two groups, and the evidence between them.
  struct Link {
    uint32_t a = 0;  // Smaller than b.
    uint32_t b = 0;
    Evidence evidence;
  };
  // Finds the two groups with the largest surplus of support. False if no two
  // groups have any evidence between them.
  bool Strongest(Link* strongest) const {
    bool any = false;
    for (const auto& [a, neighbours] : links_) {
      for (auto it = neighbours.upper_bound(a); it != neighbours.end(); ++it) {
        if (!any || it->second.IsStronger(strongest->evidence)) {
          *strongest = {a, it->first, it->second};
          any = true;
        }
      }
    }
    return any;
  }

  void Join(uint32_t a, uint32_t b) {
    auto& joined = members_[a];
    joined.insert(members_[b].begin(), members_[b].end());
    members_.erase(b);
    const auto neighbours = std::move(links_[b]);
    links_.erase(b);
    for (const auto& [other, evidence] : neighbours) {
      links_[other].erase(b);
      if (other != a) Connect(a, other, evidence);
    }
  }

  const std::map<uint32_t, std::set<uint32_t>>& members() const {
    return members_;
  }

 private:
  void Connect(uint32_t a, uint32_t b, const Evidence& evidence) {
    links_[a][b].Add(evidence);
    links_[b][a].Add(evidence);
  }

  std::map<uint32_t, std::set<uint32_t>> members_;
  std::map<uint32_t, std::map<uint32_t, Evidence>> links_;
};

}  // namespace

ViewGroups FindViewGroups(const Reconstruction& model,
                          const std::vector<PairSupport>& pairs) {
  ViewGroups result;
  std::set<uint32_t> unseen;
  for (const PosedImage& image : model.images) unseen.insert(image.id);
  if (unseen.size() < kMinPhotos) {
    result.groups.emplace_back(unseen.begin(), unseen.end());
    return result;
  }
  Contraction contraction(pairs);
  Contraction::Link link;
  bool held = true;
  // The groups are final as soon as nothing holds two of them together. Joining
  // goes on all the same, because the score is the least share met on the way.
  while (contraction.Strongest(&link)) {
    if (held && !link.evidence.HoldsTogether()) {
      held = false;
      for (const auto& [leader, members] : contraction.members()) {
        result.groups.emplace_back(members.begin(), members.end());
      }
    }
    if (link.evidence.against >= kMinAgainst) {
      result.score = std::min(result.score, link.evidence.share());
    }
    contraction.Join(link.a, link.b);
  }
  if (held) {
    for (const auto& [leader, members] : contraction.members()) {
      result.groups.emplace_back(members.begin(), members.end());
    }
    // Groups without any evidence between them do not speak against the model.
    for (size_t g = 1; g < result.groups.size(); ++g) {
      result.groups[0].insert(result.groups[0].end(),
                              result.groups[g].begin(),
                              result.groups[g].end());
    }
    if (!result.groups.empty()) result.groups.resize(1);
  }
  std::stable_sort(
      result.groups.begin(),
      result.groups.end(),
      [](const auto& a, const auto& b) { return a.size() > b.size(); });
  if (result.groups.empty()) result.groups.emplace_back();
  std::map<uint32_t, size_t> group;
  for (size_t g = 0; g < result.groups.size(); ++g) {
    for (const uint32_t id : result.groups[g]) {
      group[id] = g;
      unseen.erase(id);
    }
  }
  result.groups[0].insert(result.groups[0].end(), unseen.begin(), unseen.end());
  std::sort(result.groups[0].begin(), result.groups[0].end());
  for (const PairSupport& pair : pairs) {
    if (group[pair.image_id1] != group[pair.image_id2] && pair.fits) {
      result.suspects.emplace_back(pair.image_id1, pair.image_id2);
    }
  }
  return result;
}

StatusOr<ViewGroups> GroupViews(const Reconstruction& model,
                                const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                          MatchDatabase::Open(path));
  FREEGS_ASSIGN_OR_RETURN(const std::vector<PairSupport> pairs,
                          MeasureSupport(model, database));
  return FindViewGroups(model, pairs);
}

}  // namespace freegs::sfm
