// SPDX-License-Identifier: BSD-3-Clause
// Portions: what each reads, runs and leaves.

#include "sfm/colmap/portioned_import.h"

#include <algorithm>
#include <system_error>

#include "core/io/files.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxPortions = 32;
constexpr size_t kMinPairsPerPortion = 20;

struct PortionFiles {
  fs::path database;
  fs::path list;

  PortionFiles(const fs::path& folder, int number)
      : database(folder / ("matches_" + std::to_string(number) + ".db")),
        list(folder / ("matches_" + std::to_string(number) + ".txt")) {}

  void Remove() const {
    RemoveDatabase(database);
    std::error_code ignored;
    fs::remove(list, ignored);
  }
};

}  // namespace

std::string PlainPhotoName(uint32_t id) { return "photo" + std::to_string(id); }

PortionedImport::PortionedImport(const StepContext& context,
                                 PortionedImportOptions options)
    : context_(context),
      options_(std::move(options)),
      base_path_(context.input.work_folder / "matches.db") {}

PortionedImport::~PortionedImport() { RemoveDatabase(base_path_); }

Status PortionedImport::MakeBase() {
  const fs::path whole = base_path_.string() + ".tmp";
  RemoveDatabase(base_path_);
  FREEGS_RETURN_IF_ERROR(CopyDatabase(options_.database, whole));
  {
    FREEGS_ASSIGN_OR_RETURN(MatchDatabase copy, MatchDatabase::Open(whole));
    FREEGS_RETURN_IF_ERROR(copy.ClearMatchesAndDescriptors());
    FREEGS_RETURN_IF_ERROR(copy.RenamePhotos(PlainPhotoName));
    // Copying leaves the freed space behind.
    FREEGS_RETURN_IF_ERROR(copy.CopyTo(base_path_));
  }
  RemoveDatabase(whole);
  return {};
}

StatusOr<ChildCommand> PortionedImport::Start(const Portion& portion) {
  const PortionFiles files(context_.input.work_folder, portion.number);
  files.Remove();
  FREEGS_ASSIGN_OR_RETURN(const std::string list, options_.list(portion.pairs));
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(files.list, list));
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
  arguments.Require("match_list_path", files.list.string());
  arguments.Require("match_type", "raw");
  arguments.Prefer({"FeatureMatching.use_gpu", "SiftMatching.use_gpu"}, "0");
  arguments.AddAll({"FeatureMatching.num_threads", "SiftMatching.num_threads"},
                   "1");
  // COLMAP's 10000 are spent on pairs that no homography explains. As many
  // pairs and matches are found with these.
  arguments.Prefer(
      {"TwoViewGeometry.max_num_trials", "SiftMatching.max_num_trials"},
      "1000");
  arguments.AddAll(
      {"random_seed", "default_random_seed", "TwoViewGeometry.random_seed"},
      std::to_string(context_.input.seed % 2147483647));
  return arguments.Finish();
}

Status PortionedImport::Finish(const Portion& portion,
                               const ChildResult& result) {
  FREEGS_RETURN_IF_ERROR(CheckEnded(context_, "matches_importer", result));
  const PortionFiles files(context_.input.work_folder, portion.number);
  FREEGS_ASSIGN_OR_RETURN(MatchDatabase database,
                          MatchDatabase::Open(options_.database));
  FREEGS_RETURN_IF_ERROR(database.CopyMatchesFrom(files.database));
  imported_ += static_cast<double>(portion.pairs.size());
  context_.Report("matching", imported_, total_, "");
  return {};
}

Status PortionedImport::Run(const std::vector<IdPair>& pairs,
                            const std::set<int>& done,
                            const std::function<Status(int)>& on_done) {
  if (num_portions_ == 0) FREEGS_RETURN_IF_ERROR(MakeBase());
  total_ += static_cast<double>(pairs.size());
  std::vector<Portion> todo;
  const size_t size = std::max(
      kMinPairsPerPortion, (pairs.size() + kMaxPortions - 1) / kMaxPortions);
  for (size_t first = 0; first < pairs.size(); first += size) {
    const size_t end = std::min(first + size, pairs.size());
    Portion portion{num_portions_++,
                    {pairs.begin() + first, pairs.begin() + end}};
    if (done.contains(portion.number)) {
      imported_ += static_cast<double>(portion.pairs.size());
      // Left behind when killed right after it was recorded.
      PortionFiles(context_.input.work_folder, portion.number).Remove();
    } else {
      todo.push_back(std::move(portion));
    }
  }
  context_.Report("matching", imported_, total_, "");

  ChildBatch batch;
  batch.count = todo.size();
  batch.max_parallel = context_.num_threads;
  batch.prepare = [&](size_t i) { return Start(todo[i]); };
  batch.finished = [&](size_t i, const ChildResult& result) -> Status {
    FREEGS_RETURN_IF_ERROR(Finish(todo[i], result));
    // Only now: a portion is recorded when its matches are in the database.
    FREEGS_RETURN_IF_ERROR(on_done(todo[i].number));
    PortionFiles(context_.input.work_folder, todo[i].number).Remove();
    return {};
  };
  return RunChildren(batch, context_.input.cancellation);
}

}  // namespace freegs::sfm
