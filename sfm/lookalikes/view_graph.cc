// SPDX-License-Identifier: BSD-3-Clause
// Agreement of a reconstruction with its matches.

#include "sfm/lookalikes/view_graph.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <unordered_map>

#include "core/disjoint_sets.h"

namespace freegs::sfm {
namespace {

// Image ids, which may be any numbers, numbered from 0.
std::unordered_map<uint32_t, uint32_t> NumberImages(
    const std::vector<PairAgreement>& pairs) {
  std::unordered_map<uint32_t, uint32_t> number;
  for (const PairAgreement& pair : pairs) {
    for (const uint32_t id : {pair.image_id1, pair.image_id2}) {
      number.try_emplace(id, static_cast<uint32_t>(number.size()));
    }
  }
  return number;
}

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
  const auto number = NumberImages(pairs);
  // Kruskal's algorithm joins the images by the strongest pairs.
  DisjointSets tree(number.size());
  // The same without the pairs that the model contradicts.
  DisjointSets parts(number.size());
  for (const size_t i : order) {
    const PairAgreement& pair = pairs[i];
    const uint32_t a = number.at(pair.image_id1);
    const uint32_t b = number.at(pair.image_id2);
    if (!tree.Join(a, b)) continue;
    if (pair.contradicts()) {
      result.strongest.emplace_back(pair.image_id1, pair.image_id2);
    } else {
      parts.Join(a, b);
    }
  }
  if (result.strongest.empty()) return result;
  for (const PairAgreement& pair : pairs) {
    if (pair.agrees() && parts.Find(number.at(pair.image_id1)) !=
                             parts.Find(number.at(pair.image_id2))) {
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
