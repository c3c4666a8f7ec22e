// SPDX-License-Identifier: BSD-3-Clause
// The matching step: pairs of photos in fixed portions, each by one program
// with one thread, so that the result does not depend on how many run at once.

#include <algorithm>
#include <functional>
#include <map>
#include <system_error>

#include "core/files.h"
#include "sfm/colmap_steps.h"
#include "sfm/match_database.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxPortions = 32;
constexpr size_t kMinPairsPerPortion = 20;

using IdPair = std::pair<uint32_t, uint32_t>;

// Pairs of database ids. Photos that COLMAP could not read are left out.
StatusOr<std::vector<IdPair>> PairsById(const StepContext& context,
                                        const MatchDatabase& database) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<MatchDatabase::Photo> photos,
                          database.Photos());
  std::map<std::string, uint32_t> ids;
  for (const auto& photo : photos) {
    if (photo.num_features > 0) ids[photo.name] = photo.id;
  }
  std::vector<uint32_t> usable;
  for (const SfmPhoto& photo : context.input.photos) {
    const auto it = ids.find(photo.name);
    if (it != ids.end()) usable.push_back(it->second);
  }
  std::vector<IdPair> pairs;
  for (const auto& [i, j] :
       SelectPairs(static_cast<int>(usable.size()), context.options)) {
    pairs.emplace_back(usable[i], usable[j]);
  }
  return pairs;
}

struct Portion {
  int number = 0;
  std::vector<IdPair> pairs;
};

std::vector<Portion> SplitPairs(const std::vector<IdPair>& pairs) {
  const size_t size = std::max(
      kMinPairsPerPortion, (pairs.size() + kMaxPortions - 1) / kMaxPortions);
  std::vector<Portion> portions;
  for (size_t first = 0; first < pairs.size(); first += size) {
    Portion portion;
    portion.number = static_cast<int>(portions.size());
    portion.pairs.assign(pairs.begin() + first,
                         pairs.begin() + std::min(first + size, pairs.size()));
    portions.push_back(std::move(portion));
  }
  return portions;
}

// Names in the copies that a portion works on. (COLMAP's pair lists are
// separated by spaces, which names of photos may have.)
std::string PlainName(uint32_t id) { return "photo" + std::to_string(id); }

struct PortionFiles {
  fs::path database;
  fs::path pairs;

  PortionFiles(const fs::path& folder, int number)
      : database(folder / ("matches_" + std::to_string(number) + ".db")),
        pairs(folder / ("matches_" + std::to_string(number) + ".txt")) {}

  void Remove() const {
    std::error_code ignored;
    for (const char* suffix : {"", "-wal", "-shm", "-journal"}) {
      fs::remove(database.string() + suffix, ignored);
    }
    fs::remove(pairs, ignored);
  }
};

StatusOr<ChildCommand> PreparePortion(const StepContext& context,
                                      const MatchDatabase& database,
                                      const Portion& portion) {
  const PortionFiles files(context.input.work_folder, portion.number);
  files.Remove();
  FREEGS_RETURN_IF_ERROR(database.CopyTo(files.database));
  FREEGS_ASSIGN_OR_RETURN(MatchDatabase copy,
                          MatchDatabase::Open(files.database));
  FREEGS_RETURN_IF_ERROR(copy.ClearMatches());
  FREEGS_RETURN_IF_ERROR(copy.RenamePhotos(PlainName));
  std::string text;
  for (const auto& [a, b] : portion.pairs) {
    text += PlainName(a) + " " + PlainName(b) + "\n";
  }
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(files.pairs, text));

  const std::string command = "matches_importer";
  FREEGS_ASSIGN_OR_RETURN(
      const std::set<std::string> options,
      context.colmap.Options(command, context.input.cancellation));
  ChildCommand child = context.colmap.Command(command);
  child.log_file = context.LogFile(command);
  ColmapArguments arguments(std::move(child), options);
  arguments.Require("database_path", files.database.string());
  arguments.Require("match_list_path", files.pairs.string());
  arguments.Require("match_type", "pairs");
  arguments.Prefer({"FeatureMatching.use_gpu", "SiftMatching.use_gpu"},
                   context.options.use_gpu ? "1" : "0");
  arguments.AddAll({"FeatureMatching.num_threads", "SiftMatching.num_threads"},
                   "1");
  arguments.AddAll(
      {"random_seed", "default_random_seed", "TwoViewGeometry.random_seed"},
      std::to_string(context.input.seed % 2147483647));
  return arguments.Finish();
}

}  // namespace

Status MatchFeatures(const StepContext& context,
                     const fs::path& database_path,
                     const std::set<int>& done,
                     const std::function<Status(int portion)>& on_done) {
  std::vector<Portion> todo;
  double total = 0;
  double matched = 0;
  {
    FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                            MatchDatabase::Open(database_path));
    FREEGS_ASSIGN_OR_RETURN(const std::vector<IdPair> pairs,
                            PairsById(context, database));
    total = static_cast<double>(pairs.size());
    for (Portion& portion : SplitPairs(pairs)) {
      if (done.contains(portion.number)) {
        matched += static_cast<double>(portion.pairs.size());
      } else {
        todo.push_back(std::move(portion));
      }
    }
  }
  context.Report("matching", matched, total, "");

  ChildBatch batch;
  batch.count = todo.size();
  // A graphics card is one: more programs would only share it.
  batch.max_parallel = context.options.use_gpu ? 1 : context.num_threads;
  batch.prepare = [&](size_t i) -> StatusOr<ChildCommand> {
    FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                            MatchDatabase::Open(database_path));
    return PreparePortion(context, database, todo[i]);
  };
  batch.finished = [&](size_t i, const ChildResult& result) -> Status {
    FREEGS_RETURN_IF_ERROR(CheckEnded(context, "matches_importer", result));
    const PortionFiles files(context.input.work_folder, todo[i].number);
    FREEGS_ASSIGN_OR_RETURN(MatchDatabase database,
                            MatchDatabase::Open(database_path));
    FREEGS_RETURN_IF_ERROR(database.CopyMatchesFrom(files.database));
    FREEGS_RETURN_IF_ERROR(on_done(todo[i].number));
    files.Remove();
    matched += static_cast<double>(todo[i].pairs.size());
    context.Report("matching", matched, total, "");
    return {};
  };
  return RunChildren(batch, context.input.cancellation);
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
