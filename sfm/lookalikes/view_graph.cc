// SPDX-License-Identifier: BSD-3-Clause
// Agreement of a reconstruction with its matches.

#include "sfm/lookalikes/view_graph.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <unordered_map>

namespace freegs::sfm {
namespace {

// Disjoint sets of image ids.
class Parts {
 public:
  uint32_t Find(uint32_t id) {
    auto it = parent_.try_emplace(id, id).first;
    while (it->second != it->first) it = parent_.find(it->second);
    // Shortens the path for the next time.
    return parent_[id] = it->first;
  }
  // False when both were in one set already.
  bool Unite(uint32_t a, uint32_t b) {
    a = Find(a);
    b = Find(b);
    if (a == b) return false;
    parent_[b] = a;
    return true;
  }

 private:
  std::unordered_map<uint32_t, uint32_t> parent_;
};

}  // namespace

StatusOr<std::vector<PairAgreement>> MeasureAgreement(
    const Reconstruction& model, const MatchDatabase& database) {
  const auto index = IndexImages(model);
  std::vector<PairAgreement> pairs;
  FREEGS_RETURN_IF_ERROR(database.ForEachVerifiedPair(
      [&](uint32_t id1, uint32_t id2, std::span<const FeatureMatch> matches) {
        const auto it1 = index.find(id1);
        const auto it2 = index.find(id2);
        if (it1 == index.end() || it2 == index.end()) return;
        const auto& points1 = model.images[it1->second].points2d;
        const auto& points2 = model.images[it2->second].points2d;
        PairAgreement pair;
        pair.image_id1 = id1;
        pair.image_id2 = id2;
        pair.matches = static_cast<int64_t>(matches.size());
        for (const FeatureMatch& match : matches) {
          if (match.feature1 >= points1.size() ||
              match.feature2 >= points2.size()) {
            continue;
          }
          const uint64_t point1 = points1[match.feature1].point3d_id;
          const uint64_t point2 = points2[match.feature2].point3d_id;
          if (point1 == kNoPoint3D || point2 == kNoPoint3D) continue;
          ++(point1 == point2 ? pair.agreeing : pair.contradicting);
        }
        pairs.push_back(pair);
      }));
  return pairs;
}

Contradictions FindContradictions(const std::vector<PairAgreement>& pairs) {
  std::vector<size_t> order(pairs.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return pairs[a].matches > pairs[b].matches;
  });
  Contradictions result;
  Parts tree;   // Joined by the strongest pairs (Kruskal).
  Parts parts;  // The same without those that the model contradicts.
  for (const size_t i : order) {
    const PairAgreement& pair = pairs[i];
    if (!tree.Unite(pair.image_id1, pair.image_id2)) continue;
    if (pair.contradicts()) {
      result.strongest.emplace_back(pair.image_id1, pair.image_id2);
    } else {
      parts.Unite(pair.image_id1, pair.image_id2);
    }
  }
  if (result.strongest.empty()) return result;
  for (const PairAgreement& pair : pairs) {
    if (pair.agrees() &&
        parts.Find(pair.image_id1) != parts.Find(pair.image_id2)) {
      result.suspects.emplace_back(pair.image_id1, pair.image_id2);
    }
  }
  return result;
}

StatusOr<Contradictions> FindContradictions(const Reconstruction& model,
                                            const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                          MatchDatabase::Open(path));
  FREEGS_ASSIGN_OR_RETURN(const std::vector<PairAgreement> pairs,
                          MeasureAgreement(model, database));
  return FindContradictions(pairs);
}

}  // namespace freegs::sfm
