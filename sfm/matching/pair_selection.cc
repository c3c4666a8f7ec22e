// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/matching/pair_selection.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>

#include "core/disjoint_sets.h"
#include "sfm/matching/photo_sequence.h"

namespace freegs::sfm {
namespace {

// Shorter sequences say too little about themselves.
constexpr int kMinSequence = 10;

// A sequence is believed when the next photo is, on average, within this share
// of the photos most alike. It would be 0.5 by chance, with a standard
// deviation of 0.1 for the shortest sequence. Orbits filmed by hand have 0.03
// to 0.06.
constexpr double kMaxMeanRank = 0.2;

// A photo with fewer verified partners gets more pairs.
constexpr int kMinPartners = 5;

PhotoPair Ordered(int i, int j) { return {std::min(i, j), std::max(i, j)}; }

// Photos that are connected; the largest set first, then by smallest member.
std::vector<std::vector<int>> Members(DisjointSets* sets) {
  std::map<uint32_t, std::vector<int>> by_first;
  for (size_t i = 0; i < sets->size(); ++i) {
    by_first[sets->Find(i)].push_back(static_cast<int>(i));
  }
  std::vector<std::vector<int>> members;
  for (auto& entry : by_first) members.push_back(std::move(entry.second));
  std::stable_sort(
      members.begin(), members.end(), [](const auto& a, const auto& b) {
        return a.size() > b.size();
      });
  return members;
}

// The `limit` most alike pairs of a member and another photo, of those that
// are not in `tried`.
std::vector<PhotoPair> BestLinks(const std::vector<int>& members,
                                 const PhotoSimilarity& similarity,
                                 const std::set<PhotoPair>& tried,
                                 size_t limit) {
  const std::set<int> inside(members.begin(), members.end());
  std::vector<std::tuple<float, int, int>> links;
  for (const int i : members) {
    for (int j = 0; j < similarity.count(); ++j) {
      if (inside.contains(j) || tried.contains(Ordered(i, j))) continue;
      links.emplace_back(-similarity.at(i, j), i, j);
    }
  }
  const size_t kept = std::min(limit, links.size());
  std::partial_sort(links.begin(), links.begin() + kept, links.end());
  std::vector<PhotoPair> pairs;
  for (size_t k = 0; k < kept; ++k) {
    pairs.push_back(Ordered(std::get<1>(links[k]), std::get<2>(links[k])));
  }
  return pairs;
}

// Adds links until every two photos are connected. Each round connects every
// component but the largest with another.
void ConnectAll(const PhotoSimilarity& similarity,
                int links_per_part,
                std::set<PhotoPair>* pairs) {
  while (true) {
    DisjointSets components(similarity.count());
    for (const auto& [i, j] : *pairs) components.Join(i, j);
    const auto parts = Members(&components);
    if (parts.size() <= 1) return;
    for (size_t k = 1; k < parts.size(); ++k) {
      const auto links =
          BestLinks(parts[k], similarity, *pairs, links_per_part);
      pairs->insert(links.begin(), links.end());
    }
  }
}

// Where the next photo of a sequence comes, on average, among all photos by
// likeness: 0 for always first, 0.5 by chance.
double MeanRankOfNext(const std::vector<int>& sequence,
                      const PhotoSimilarity& similarity) {
  double sum = 0;
  for (size_t k = 0; k + 1 < sequence.size(); ++k) {
    const int photo = sequence[k];
    const int next = sequence[k + 1];
    int above = 0;
    for (int j = 0; j < similarity.count(); ++j) {
      if (j == photo || j == next) continue;
      if (similarity.at(photo, j) >= similarity.at(photo, next)) ++above;
    }
    sum += static_cast<double>(above) / (similarity.count() - 2);
  }
  return sum / static_cast<double>(sequence.size() - 1);
}

std::vector<std::vector<int>> BelievedSequences(
    const std::vector<std::string>& names, const PhotoSimilarity& similarity) {
  std::vector<std::vector<int>> believed;
  for (auto& sequence : FindNumberedPhotos(names, kMinSequence)) {
    if (MeanRankOfNext(sequence, similarity) <= kMaxMeanRank) {
      believed.push_back(std::move(sequence));
    }
  }
  return believed;
}

void AddNeighbours(const std::vector<int>& sequence,
                   int overlap,
                   std::set<PhotoPair>* pairs) {
  for (size_t i = 0; i < sequence.size(); ++i) {
    const size_t end = std::min(sequence.size(), i + overlap + 1);
    for (size_t j = i + 1; j < end; ++j) {
      pairs->insert(Ordered(sequence[i], sequence[j]));
    }
  }
}

std::vector<PhotoPair> AllPairs(int count) {
  std::vector<PhotoPair> pairs;
  for (int i = 0; i < count; ++i) {
    for (int j = i + 1; j < count; ++j) pairs.emplace_back(i, j);
  }
  return pairs;
}

}  // namespace

Status PairSelectionOptions::Check() const {
  if (matcher != "auto" && matcher != "exhaustive" && matcher != "sequential" &&
      matcher != "retrieval") {
    return InvalidArgumentError(
        "sfm.matcher must be auto, exhaustive, sequential or retrieval");
  }
  if (max_exhaustive < 0 || num_neighbours < 1 || overlap < 1) {
    return InvalidArgumentError(
        "max_exhaustive must be at least 0, sfm.neighbours and overlap at "
        "least 1");
  }
  return {};
}

PhotoSimilarity::PhotoSimilarity(const GlobalDescriptors& descriptors,
                                 ThreadPool& pool)
    : count_(static_cast<int>(descriptors.count)),
      values_(descriptors.count * descriptors.count) {
  pool.ParallelFor(0, count_, 1, [&](int64_t first, int64_t last, int) {
    for (int64_t i = first; i < last; ++i) {
      for (int64_t j = i; j < count_; ++j) {
        const float value = descriptors.Similarity(i, j);
        values_[i * count_ + j] = value;
        values_[j * count_ + i] = value;
      }
    }
  });
}

std::vector<int> PhotoSimilarity::MostAlike(int photo) const {
  std::vector<int> others;
  others.reserve(count_);
  for (int j = 0; j < count_; ++j) {
    if (j != photo) others.push_back(j);
  }
  std::stable_sort(others.begin(), others.end(), [&](int a, int b) {
    return at(photo, a) > at(photo, b);
  });
  return others;
}

bool NeedsSimilarity(int num_photos, const PairSelectionOptions& options) {
  if (options.matcher == "exhaustive") return false;
  // With so few, all pairs are chosen anyhow.
  if (num_photos <= options.num_neighbours + 1) return false;
  return options.matcher != "auto" || num_photos > options.max_exhaustive;
}

PairSelection SelectPairs(const std::vector<std::string>& names,
                          const PhotoSimilarity& similarity,
                          const PairSelectionOptions& options) {
  const int count = static_cast<int>(names.size());
  if (!NeedsSimilarity(count, options)) return {"exhaustive", AllPairs(count)};

  std::vector<std::vector<int>> sequences;
  if (options.matcher == "sequential") {
    sequences.emplace_back(count);
    std::iota(sequences[0].begin(), sequences[0].end(), 0);
  } else if (options.matcher == "auto") {
    sequences = BelievedSequences(names, similarity);
  }
  std::set<PhotoPair> pairs;
  for (const auto& sequence : sequences) {
    AddNeighbours(sequence, options.overlap, &pairs);
  }
  for (int i = 0; i < count; ++i) {
    const std::vector<int> alike = similarity.MostAlike(i);
    for (int k = 0; k < options.num_neighbours; ++k) {
      pairs.insert(Ordered(i, alike[k]));
    }
  }
  ConnectAll(similarity, options.num_neighbours, &pairs);
  return {sequences.empty() ? "retrieval" : "sequence and retrieval",
          std::vector<PhotoPair>(pairs.begin(), pairs.end())};
}

std::vector<PhotoPair> SelectMorePairs(const PhotoSimilarity& similarity,
                                       const std::set<PhotoPair>& tried,
                                       const std::vector<PhotoPair>& verified,
                                       const PairSelectionOptions& options) {
  if (similarity.count() == 0) return {};
  DisjointSets components(similarity.count());
  std::vector<int> partners(similarity.count());
  for (const auto& [i, j] : verified) {
    components.Join(i, j);
    ++partners[i];
    ++partners[j];
  }
  std::set<PhotoPair> more;
  for (int i = 0; i < similarity.count(); ++i) {
    if (partners[i] >= kMinPartners) continue;
    int added = 0;
    for (const int j : similarity.MostAlike(i)) {
      if (added == options.num_neighbours) break;
      if (tried.contains(Ordered(i, j))) continue;
      more.insert(Ordered(i, j));
      ++added;
    }
  }
  const auto parts = Members(&components);
  for (size_t k = 1; k < parts.size(); ++k) {
    const auto links =
        BestLinks(parts[k], similarity, tried, 2 * options.num_neighbours);
    more.insert(links.begin(), links.end());
  }
  return {more.begin(), more.end()};
}

}  // namespace freegs::sfm
