// SPDX-License-Identifier: BSD-3-Clause
// The matching step. Descriptors are compared here, exactly; COLMAP then keeps
// the matches that fit a motion of the camera. It does so in fixed portions of
// pairs, one single-threaded program each: its random draws, and so the result,
// do not depend on how many run at once.

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <system_error>

#include "core/files.h"
#include "core/parallel.h"
#include "sfm/colmap_steps.h"
#include "sfm/descriptor_matching.h"
#include "sfm/match_database.h"
#include "sfm/pair_selection.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxPortions = 32;
constexpr size_t kMinPairsPerPortion = 20;

// How often pairs are chosen: to begin with, and where that connects too
// little.
constexpr int kMaxRounds = 3;

// COLMAP would call pairs with fewer matches unrelated without looking at them
// (SiftMatching.min_num_inliers).
constexpr size_t kMinMatches = 15;

using IdPair = std::pair<uint32_t, uint32_t>;
using Matches = std::vector<std::pair<uint32_t, uint32_t>>;

struct Portion {
  int number = 0;
  std::vector<IdPair> pairs;
};

// Names in the copies that a portion works on. (COLMAP's match lists are
// separated by spaces, which names of photos may have.)
std::string PlainName(uint32_t id) { return "photo" + std::to_string(id); }

struct PortionFiles {
  fs::path database;
  fs::path matches;

  PortionFiles(const fs::path& folder, int number)
      : database(folder / ("matches_" + std::to_string(number) + ".db")),
        matches(folder / ("matches_" + std::to_string(number) + ".txt")) {}

  void Remove() const {
    RemoveDatabase(database);
    std::error_code ignored;
    fs::remove(matches, ignored);
  }
};

class Matcher {
 public:
  Matcher(const StepContext& context, const fs::path& database)
      : context_(context),
        database_path_(database),
        base_path_(context.input.work_folder / "matches.db"),
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
  Status MatchRound(const std::vector<PhotoPair>& pairs,
                    const std::set<int>& done,
                    const std::function<Status(int)>& on_done);
  Status MakeBase(const MatchDatabase& database);
  StatusOr<std::string> MatchPairs(const Portion& portion);
  StatusOr<ChildCommand> StartPortion(const Portion& portion);
  Status FinishPortion(const Portion& portion, const ChildResult& result);

  const StepContext& context_;
  const fs::path database_path_;
  const fs::path base_path_;  // What each portion starts from.
  ThreadPool pool_;
  std::vector<uint32_t> ids_;  // Of photos with features, in the order given.
  std::vector<std::string> names_;  // Of the same.
  int num_portions_ = 0;            // Of the rounds so far.
  std::vector<Portion> todo_;
  std::map<uint32_t, SiftDescriptors> descriptors_;
  double total_ = 0;
  double matched_ = 0;
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
  // Photos that COLMAP could not read, or without features, are left out.
  for (const SfmPhoto& photo : context_.input.photos) {
    const auto it = ids.find(photo.name);
    if (it == ids.end()) continue;
    ids_.push_back(it->second);
    names_.push_back(photo.name);
    FREEGS_ASSIGN_OR_RETURN(descriptors_[it->second],
                            database.Descriptors(it->second));
  }
  return MakeBase(database);
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
  return PhotoSimilarity(DescribePhotos(features, options, &pool_), &pool_);
}

// Those of the pairs that COLMAP found to fit.
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

// A small copy of the database: photos and keypoints, under plain names.
Status Matcher::MakeBase(const MatchDatabase& database) {
  const fs::path whole = base_path_.string() + ".tmp";
  RemoveDatabase(base_path_);
  RemoveDatabase(whole);
  FREEGS_RETURN_IF_ERROR(database.CopyTo(whole));
  {
    FREEGS_ASSIGN_OR_RETURN(MatchDatabase copy, MatchDatabase::Open(whole));
    FREEGS_RETURN_IF_ERROR(copy.ClearMatchesAndDescriptors());
    FREEGS_RETURN_IF_ERROR(copy.RenamePhotos(PlainName));
    // Copying leaves the freed space behind.
    FREEGS_RETURN_IF_ERROR(copy.CopyTo(base_path_));
  }
  RemoveDatabase(whole);
  return {};
}

// The matches of all pairs as text that COLMAP reads: the two names, a line per
// match, an empty line.
StatusOr<std::string> Matcher::MatchPairs(const Portion& portion) {
  std::vector<Matches> matches(portion.pairs.size());
  const CancellationToken* cancellation = context_.input.cancellation;
  pool_.ParallelFor(
      0,
      static_cast<int64_t>(portion.pairs.size()),
      1,
      [&](int64_t first, int64_t last, int) {
        for (int64_t i = first; i < last; ++i) {
          if (cancellation != nullptr && cancellation->cancelled()) return;
          const auto& [a, b] = portion.pairs[i];
          matches[i] = MatchDescriptors(
              descriptors_.at(a), descriptors_.at(b), context_.matching);
        }
      });
  std::string text;
  for (size_t i = 0; i < matches.size(); ++i) {
    if (matches[i].size() < kMinMatches) continue;
    text += PlainName(portion.pairs[i].first) + " " +
            PlainName(portion.pairs[i].second) + "\n";
    for (const auto& [a, b] : matches[i]) {
      text += std::to_string(a) + " " + std::to_string(b) + "\n";
    }
    text += "\n";
  }
  return text;
}

StatusOr<ChildCommand> Matcher::StartPortion(const Portion& portion) {
  const PortionFiles files(context_.input.work_folder, portion.number);
  files.Remove();
  FREEGS_ASSIGN_OR_RETURN(const std::string matches, MatchPairs(portion));
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(files.matches, matches));
  std::error_code error;
  fs::copy_file(base_path_, files.database, error);
  if (error) {
    return InternalError(files.database.string() +
                         ": cannot be written: " + error.message());
  }
  FREEGS_ASSIGN_OR_RETURN(
      ColmapArguments arguments,
      context_.Arguments("matches_importer", portion.pairs.size() / 20));
  arguments.Require("database_path", files.database.string());
  arguments.Require("match_list_path", files.matches.string());
  arguments.Require("match_type", "raw");
  arguments.Prefer({"FeatureMatching.use_gpu", "SiftMatching.use_gpu"}, "0");
  arguments.AddAll({"FeatureMatching.num_threads", "SiftMatching.num_threads"},
                   "1");
  arguments.AddAll(
      {"random_seed", "default_random_seed", "TwoViewGeometry.random_seed"},
      std::to_string(context_.input.seed % 2147483647));
  return arguments.Finish();
}

Status Matcher::FinishPortion(const Portion& portion,
                              const ChildResult& result) {
  FREEGS_RETURN_IF_ERROR(CheckEnded(context_, "matches_importer", result));
  const PortionFiles files(context_.input.work_folder, portion.number);
  FREEGS_ASSIGN_OR_RETURN(MatchDatabase database,
                          MatchDatabase::Open(database_path_));
  FREEGS_RETURN_IF_ERROR(database.CopyMatchesFrom(files.database));
  matched_ += static_cast<double>(portion.pairs.size());
  context_.Report("matching", matched_, total_, "");
  return {};
}

Status Matcher::MatchRound(const std::vector<PhotoPair>& pairs,
                           const std::set<int>& done,
                           const std::function<Status(int)>& on_done) {
  total_ += static_cast<double>(pairs.size());
  todo_.clear();
  const size_t size = std::max(
      kMinPairsPerPortion, (pairs.size() + kMaxPortions - 1) / kMaxPortions);
  for (size_t first = 0; first < pairs.size(); first += size) {
    Portion portion;
    portion.number = num_portions_++;
    const size_t end = std::min(first + size, pairs.size());
    for (size_t k = first; k < end; ++k) {
      portion.pairs.emplace_back(ids_[pairs[k].first], ids_[pairs[k].second]);
    }
    if (done.contains(portion.number)) {
      matched_ += static_cast<double>(portion.pairs.size());
      // Left behind when killed right after it was recorded.
      PortionFiles(context_.input.work_folder, portion.number).Remove();
    } else {
      todo_.push_back(std::move(portion));
    }
  }
  context_.Report("matching", matched_, total_, "");

  ChildBatch batch;
  batch.count = todo_.size();
  batch.max_parallel = context_.num_threads;
  batch.prepare = [&](size_t i) { return StartPortion(todo_[i]); };
  batch.finished = [&](size_t i, const ChildResult& result) -> Status {
    FREEGS_RETURN_IF_ERROR(FinishPortion(todo_[i], result));
    // Only now: a portion is recorded when its matches are in the database.
    FREEGS_RETURN_IF_ERROR(on_done(todo_[i].number));
    PortionFiles(context_.input.work_folder, todo_[i].number).Remove();
    return {};
  };
  return RunChildren(batch, context_.input.cancellation);
}

StatusOr<MatchedPairs> Matcher::Run(const std::set<int>& done,
                                    const std::function<Status(int)>& on_done) {
  FREEGS_ASSIGN_OR_RETURN(const PhotoSimilarity similarity, CompareLooks());
  PairSelection selection =
      SelectPairs(names_, similarity, context_.options.pairs);
  std::set<PhotoPair> tried;
  std::vector<PhotoPair> next = std::move(selection.pairs);
  for (int round = 0; round < kMaxRounds && !next.empty(); ++round) {
    FREEGS_RETURN_IF_ERROR(MatchRound(next, done, on_done));
    tried.insert(next.begin(), next.end());
    FREEGS_ASSIGN_OR_RETURN(const std::vector<PhotoPair> verified,
                            Verified(tried));
    next = SelectMorePairs(similarity, tried, verified, context_.options.pairs);
  }
  RemoveDatabase(base_path_);
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
