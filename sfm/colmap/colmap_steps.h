// SPDX-License-Identifier: BSD-3-Clause
// The steps of structure from motion that COLMAP does: cameras, matches,
// mapping, poses for further photos, and points for known poses. The caller
// decides on their order and remembers what is done.
//
//   FREEGS_RETURN_IF_ERROR(RegisterPhotos(context, database));
//   FREEGS_RETURN_IF_ERROR(ExtractFeatures(context, database));
//   FREEGS_ASSIGN_OR_RETURN(const MatchedPairs pairs,
//                           MatchFeatures(context, database, {}, on_done));
//   FREEGS_ASSIGN_OR_RETURN(const std::vector<Reconstruction> models,
//                           MapPhotos(context, database, folder, {}));

#ifndef FREEGS_SFM_COLMAP_COLMAP_STEPS_H_
#define FREEGS_SFM_COLMAP_COLMAP_STEPS_H_

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/status.h"
#include "sfm/colmap/colmap_program.h"
#include "sfm/colmap/sfm_options.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// What every step needs. The references must outlive it.
struct StepContext {
  const SfmInput& input;
  const SfmOptions& options;
  ColmapProgram& colmap;
  int num_threads = 1;

  // The log file of a COLMAP command, below the work folder.
  std::filesystem::path LogFile(const std::string& command) const;

  // Begins the arguments of a COLMAP command that writes to its LogFile() and
  // is killed after TimeLimit(photos).
  StatusOr<ColmapArguments> Arguments(const std::string& command,
                                      size_t photos) const;

  // Makes a command of the mapper give the same bytes for the same seed.
  void MakeRepeatable(ColmapArguments* arguments) const;

  // Reports progress to the caller.
  void Report(const std::string& step,
              double done,
              double total,
              const std::string& detail) const;
};

// What it means when a program crashes, which is when it brings a signal upon
// itself by an error in it, such as SIGSEGV or SIGABRT.
enum class Crash {
  kNoVerdict,  // Nothing: the next run tries again.
  kVerdict,    // It cannot do this, and would crash again.
};

// Returns an error with the last lines of output unless the program ended well:
// kInternal when a signal ended it or the disk is full, from which the next run
// goes on, else kUnusableResult, also for a crash that is a verdict.
Status CheckEnded(const std::string& program,
                  const std::string& command,
                  const std::filesystem::path& log,
                  const ChildResult& result,
                  Crash crash = Crash::kNoVerdict);
Status CheckEnded(const StepContext& context,
                  const std::string& command,
                  const ChildResult& result,
                  Crash crash = Crash::kNoVerdict);

// Makes a new database that contains the photos and their cameras, but no
// features. The photos are numbered group by group, where those of a group
// share a camera, and within a group in the given order.
Status RegisterPhotos(const StepContext& context,
                      const std::filesystem::path& database);

// Matches the pairs that options.pairs choose, writes the matches into the
// database, and writes the list of pairs into pairs.txt beside it. It works in
// portions. `done` has the numbers of those that earlier calls finished; they
// are skipped. on_done is called with the number of each further portion.
StatusOr<MatchedPairs> MatchFeatures(
    const StepContext& context,
    const std::filesystem::path& database,
    const std::set<int>& done,
    const std::function<Status(int portion)>& on_done);

// The time in seconds after which a COLMAP command is considered stuck, when it
// works on so many photos or on twenty times as many pairs.
double TimeLimit(size_t photos);

// Two photos with which a model can begin, and what was seen of them.
struct InitialPair {
  uint32_t id1 = 0;  // Smaller than id2.
  uint32_t id2 = 0;
  int64_t matches = 0;   // Those that lie in front of both cameras.
  double angle_deg = 0;  // Median angle between their rays.
};

// COLMAP drops models of fewer photos, unless it is told not to.
inline constexpr size_t kUsualMinModel = 10;

// COLMAP takes two photos to begin with for granted if the median angle between
// their rays is at least this, in degrees.
inline constexpr double kUsualStartAngleDeg = 16;

// How to make models from a database.
struct MapperOptions {
  std::string step = "mapping";  // The name of the step in progress reports.

  // Whether there is a result without this mapping. If COLMAP crashes, that is
  // kUnusableResult then, because it would crash again.
  bool further = false;

  // Whether to lower COLMAP's thresholds, for few or weakly connected photos.
  bool relaxed = false;

  // Whether to keep models of 3 photos or more. Otherwise COLMAP drops one that
  // has few of the photos, and begins elsewhere.
  bool small_models = false;

  // Whether to map only the photos of the context's input, and not all of the
  // database.
  bool listed = false;

  // A model to which the other photos are registered. Its ids are those of the
  // database. It must outlive the call.
  const Reconstruction* start = nullptr;

  // Without `start`, the photos to begin with. There is then one model at most.
  // Without this, COLMAP looks for a pair itself, and for another one as long
  // as many photos are left.
  std::optional<InitialPair> pair = std::nullopt;
};

// Makes models from a database and returns them, the largest first; there may
// be none. `folder` is made anew for COLMAP's output and deleted at the end.
StatusOr<std::vector<Reconstruction>> MapPhotos(
    const StepContext& context,
    const std::filesystem::path& database,
    const std::filesystem::path& folder,
    const MapperOptions& options);

// Gives the photos that a model lacks a pose each, by the points of the model
// that they see. Poses of the model and positions of its points stay as they
// are. Photos that see too few points, or that would get a lens that no photo
// has, are left out. `model` has the ids of the database. `folder` is made anew
// for COLMAP's output and deleted at the end. Errors: those of a COLMAP
// command, with kUnusableResult for a crash.
StatusOr<Reconstruction> RegisterOtherPhotos(
    const StepContext& context,
    const std::filesystem::path& database,
    const std::filesystem::path& folder,
    const Reconstruction& model);

// Finds the 3D points that the verified matches in the database show from the
// given poses. Poses and cameras stay as they are. `poses` has images without
// features, with the ids of the database; the result has all features. `folder`
// is made anew for COLMAP's output and deleted at the end. The points have no
// colours. Errors: those of a COLMAP command, with kUnusableResult for a crash:
// release 3.8 crashes when there are no points.
StatusOr<Reconstruction> TriangulatePoints(
    const StepContext& context,
    const std::filesystem::path& database,
    const std::filesystem::path& folder,
    const Reconstruction& poses);

// Most photos first, then most points, then as they were.
void SortBySize(std::vector<Reconstruction>* models);

// The number of photos in the largest of the models, which is the first; 0
// without models.
inline size_t NumRegistered(const std::vector<Reconstruction>& models) {
  return models.empty() ? 0 : models[0].images.size();
}

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_COLMAP_COLMAP_STEPS_H_
