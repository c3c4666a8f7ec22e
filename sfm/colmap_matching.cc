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

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxPortions = 32;
constexpr size_t kMinPairsPerPortion = 20;

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

  // Splits the pairs into portions and reads the descriptors.
  Status Prepare(const std::set<int>& done);

  Status Run(const std::function<Status(int portion)>& on_done);

 private:
  Status ReadDescriptors(const MatchDatabase& database,
                         const std::vector<MatchDatabase::Photo>& photos);
  Status MakeBase(const MatchDatabase& database);
  StatusOr<std::string> MatchPairs(const Portion& portion);
  StatusOr<ChildCommand> StartPortion(const Portion& portion);
  Status FinishPortion(const Portion& portion, const ChildResult& result);

  const StepContext& context_;
  const fs::path database_path_;
  const fs::path base_path_;  // What each portion starts from.
  ThreadPool pool_;
  std::vector<Portion> todo_;
  std::map<uint32_t, SiftDescriptors> descriptors_;
  double total_ = 0;
  double matched_ = 0;
};

Status Matcher::Prepare(const std::set<int>& done) {
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                          MatchDatabase::Open(database_path_));
  FREEGS_ASSIGN_OR_RETURN(const std::vector<MatchDatabase::Photo> photos,
                          database.Photos());
  std::map<std::string, uint32_t> ids;
  for (const auto& photo : photos) {
    if (photo.num_features > 0) ids[photo.name] = photo.id;
  }
  // Photos that COLMAP could not read, or without features, are left out.
  std::vector<uint32_t> usable;
  for (const SfmPhoto& photo : context_.input.photos) {
    const auto it = ids.find(photo.name);
    if (it != ids.end()) usable.push_back(it->second);
  }
  std::vector<IdPair> pairs;
  for (const auto& [i, j] :
       SelectPairs(static_cast<int>(usable.size()), context_.options)) {
    pairs.emplace_back(usable[i], usable[j]);
  }
  total_ = static_cast<double>(pairs.size());

  const size_t size = std::max(
      kMinPairsPerPortion, (pairs.size() + kMaxPortions - 1) / kMaxPortions);
  for (size_t first = 0; first < pairs.size(); first += size) {
    Portion portion;
    portion.number = static_cast<int>(first / size);
    portion.pairs.assign(pairs.begin() + first,
                         pairs.begin() + std::min(first + size, pairs.size()));
    if (done.contains(portion.number)) {
      matched_ += static_cast<double>(portion.pairs.size());
      // Left behind when killed right after it was recorded.
      PortionFiles(context_.input.work_folder, portion.number).Remove();
    } else {
      todo_.push_back(std::move(portion));
    }
  }
  context_.Report("matching", matched_, total_, "");
  FREEGS_RETURN_IF_ERROR(ReadDescriptors(database, photos));
  return MakeBase(database);
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

Status Matcher::ReadDescriptors(
    const MatchDatabase& database,
    const std::vector<MatchDatabase::Photo>& photos) {
  for (const MatchDatabase::Photo& photo : photos) {
    FREEGS_ASSIGN_OR_RETURN(descriptors_[photo.id],
                            database.Descriptors(photo.id));
  }
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
  const std::string command = "matches_importer";
  FREEGS_ASSIGN_OR_RETURN(
      const std::set<std::string> options,
      context_.colmap.Options(command, context_.input.cancellation));
  ChildCommand child = context_.colmap.Command(command);
  child.log_file = context_.LogFile(command);
  child.time_limit_s = TimeLimit(portion.pairs.size() / 20);
  ColmapArguments arguments(std::move(child), options);
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

Status Matcher::Run(const std::function<Status(int portion)>& on_done) {
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
  FREEGS_RETURN_IF_ERROR(RunChildren(batch, context_.input.cancellation));
  RemoveDatabase(base_path_);
  return {};
}

}  // namespace

Status MatchFeatures(const StepContext& context,
                     const fs::path& database_path,
                     const std::set<int>& done,
                     const std::function<Status(int portion)>& on_done) {
  Matcher matcher(context, database_path);
  FREEGS_RETURN_IF_ERROR(matcher.Prepare(done));
  return matcher.Run(on_done);
}

std::vector<std::pair<int, int>> SelectPairs(int count,
                                             const SfmOptions& options) {
  const bool exhaustive =
      options.matcher == "exhaustive" ||
      (options.matcher == "auto" && count <= options.max_exhaustive);
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < count; ++i) {
    for (int j = i + 1; j < count; ++j) {
      const int gap = j - i;
      // Neighbours; then at doubling distance; then, to close loops, the photos
      // at every overlap-th place with each other.
      const bool near = gap <= options.overlap;
      const bool power = (gap & (gap - 1)) == 0 && gap <= 1 << 8;
      const bool key = i % options.overlap == 0 && j % options.overlap == 0;
      if (exhaustive || near || power || key) pairs.emplace_back(i, j);
    }
  }
  return pairs;
}

}  // namespace freegs::sfm
