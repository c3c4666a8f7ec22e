// SPDX-License-Identifier: BSD-3-Clause
// The matching step. Descriptors are compared here, exactly; COLMAP then keeps
// the matches that fit a motion of the camera. It may also look for more
// matches once it knows that motion.

#include <algorithm>
#include <functional>
#include <map>

#include "core/cancellation.h"
#include "core/io/files.h"
#include "core/parallel.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/colmap/portioned_import.h"
#include "sfm/matching/descriptor_matching.h"
#include "sfm/matching/match_database.h"
#include "sfm/matching/pair_selection.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

// How often pairs are chosen: to begin with, and where that connects too
// little.
constexpr int kMaxRounds = 3;

using Matches = std::vector<std::pair<uint32_t, uint32_t>>;

class Matcher {
 public:
  Matcher(const StepContext& context, const fs::path& database)
      : context_(context),
        database_path_(database),
        pool_(context.num_threads) {}

  // Finds the photos that have features, and reads these.
  Status Prepare();

  // Matches the pairs that SelectPairs() and then SelectMorePairs() name.
  // Portions in `done` are already in the database.
  StatusOr<MatchedPairs> Run(const std::set<int>& done,
                             const std::function<Status(int)>& on_done);

 private:
  StatusOr<PhotoSimilarity> CompareLooks();
  StatusOr<std::vector<PhotoPair>> Verified(
      const std::set<PhotoPair>& tried) const;
  Status WritePairs(const std::set<PhotoPair>& pairs) const;
  std::string MatchPairs(const std::vector<IdPair>& pairs);

  const StepContext& context_;
  const fs::path database_path_;
  ThreadPool pool_;
  std::vector<uint32_t> ids_;       // Photos with features, in the order given.
  std::vector<std::string> names_;  // Names of these photos.
  std::map<uint32_t, SiftDescriptors> descriptors_;
};

Status Matcher::Prepare() {
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                          MatchDatabase::Open(database_path_));
  FREEGS_ASSIGN_OR_RETURN(const std::vector<MatchDatabase::Photo> photos,
                          database.Photos());
  std::map<std::string, uint32_t> ids;
  for (const auto& photo : photos) {
    if (photo.num_features > 0) ids[photo.name] = photo.id;
  }
  // Photos without features are left out.
  for (const SfmPhoto& photo : context_.input.photos) {
    const auto it = ids.find(photo.name);
    if (it == ids.end()) continue;
    ids_.push_back(it->second);
    names_.push_back(photo.name);
    FREEGS_ASSIGN_OR_RETURN(descriptors_[it->second],
                            database.Descriptors(it->second));
  }
  return {};
}

// What was matched, as the list of names that COLMAP's matches_importer takes
// (match_type pairs).
Status Matcher::WritePairs(const std::set<PhotoPair>& pairs) const {
  std::string text;
  for (const auto& [i, j] : pairs) {
    text += names_[i] + " " + names_[j] + "\n";
  }
  return WriteFileAtomic(database_path_.parent_path() / "pairs.txt", text);
}

// How alike the photos look; empty when nobody asks.
StatusOr<PhotoSimilarity> Matcher::CompareLooks() {
  if (!NeedsSimilarity(static_cast<int>(ids_.size()), context_.options.pairs)) {
    return PhotoSimilarity();
  }
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                          MatchDatabase::Open(database_path_));
  std::vector<PhotoFeatures> features;
  for (const uint32_t id : ids_) {
    FREEGS_ASSIGN_OR_RETURN(std::vector<float> scales,
                            database.FeatureScales(id));
    features.push_back({&descriptors_.at(id), std::move(scales)});
  }
  GlobalDescriptorOptions options;
  options.seed = context_.input.seed;
  return PhotoSimilarity(DescribePhotos(features, options, pool_), pool_);
}

// Returns those pairs of `tried` that COLMAP found to fit.
StatusOr<std::vector<PhotoPair>> Matcher::Verified(
    const std::set<PhotoPair>& tried) const {
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                          MatchDatabase::Open(database_path_));
  std::map<uint32_t, int> index;
  for (size_t i = 0; i < ids_.size(); ++i) index[ids_[i]] = static_cast<int>(i);
  std::vector<PhotoPair> verified;
  FREEGS_RETURN_IF_ERROR(database.ForEachVerifiedPair(
      [&](uint32_t id1, uint32_t id2, std::span<const FeatureMatch>) {
        const auto first = index.find(id1);
        const auto second = index.find(id2);
        if (first == index.end() || second == index.end()) return;
        const PhotoPair pair = std::minmax(first->second, second->second);
        // An interrupted call may have left pairs of later rounds.
        if (tried.contains(pair)) verified.push_back(pair);
      }));
  return verified;
}

// The matches of all pairs as text that COLMAP reads: the two names, a line per
// match, an empty line. Pairs with few matches or none are in it, too, so that
// the database knows that they were compared.
std::string Matcher::MatchPairs(const std::vector<IdPair>& pairs) {
  std::vector<Matches> matches(pairs.size());
  const CancellationToken* cancellation = context_.input.cancellation;
  pool_.ParallelFor(0,
                    static_cast<int64_t>(pairs.size()),
                    1,
                    [&](int64_t first, int64_t last, int) {
                      for (int64_t i = first; i < last; ++i) {
                        if (IsCancelled(cancellation)) return;
                        const auto& [a, b] = pairs[i];
                        matches[i] = MatchDescriptors(descriptors_.at(a),
                                                      descriptors_.at(b));
                      }
                    });
  std::string text;
  for (size_t i = 0; i < matches.size(); ++i) {
    text += PlainPhotoName(pairs[i].first) + " " +
            PlainPhotoName(pairs[i].second) + "\n";
    for (const auto& [a, b] : matches[i]) {
      text += std::to_string(a) + " " + std::to_string(b) + "\n";
    }
    text += "\n";
  }
  return text;
}

StatusOr<MatchedPairs> Matcher::Run(const std::set<int>& done,
                                    const std::function<Status(int)>& on_done) {
  FREEGS_ASSIGN_OR_RETURN(const PhotoSimilarity similarity, CompareLooks());
  PairSelection selection =
      SelectPairs(names_, similarity, context_.options.pairs);
  PortionedImport import(
      context_,
      {.database = database_path_,
       .list =
           [this](const std::vector<IdPair>& pairs) -> StatusOr<std::string> {
         std::string text = MatchPairs(pairs);
         // The list of a cancelled call lacks matches, and must not count as a
         // portion that is done.
         if (IsCancelled(context_.input.cancellation)) {
           return InterruptedError("matching was stopped on request");
         }
         return text;
       }});
  std::set<PhotoPair> tried;
  std::vector<PhotoPair> next = std::move(selection.pairs);
  for (int round = 0; round < kMaxRounds && !next.empty(); ++round) {
    std::vector<IdPair> pairs;
    for (const auto& [i, j] : next) pairs.emplace_back(ids_[i], ids_[j]);
    FREEGS_RETURN_IF_ERROR(import.Run(pairs, done, on_done));
    tried.insert(next.begin(), next.end());
    FREEGS_ASSIGN_OR_RETURN(const std::vector<PhotoPair> verified,
                            Verified(tried));
    next = SelectMorePairs(similarity, tried, verified, context_.options.pairs);
  }
  FREEGS_RETURN_IF_ERROR(WritePairs(tried));
  const size_t count = ids_.size();
  return MatchedPairs{std::move(selection.strategy),
                      tried.size(),
                      count < 2 ? 0 : count * (count - 1) / 2};
}

}  // namespace

StatusOr<MatchedPairs> MatchFeatures(
    const StepContext& context,
    const fs::path& database_path,
    const std::set<int>& done,
    const std::function<Status(int portion)>& on_done) {
  Matcher matcher(context, database_path);
  FREEGS_RETURN_IF_ERROR(matcher.Prepare());
  return matcher.Run(done, on_done);
}

}  // namespace freegs::sfm
