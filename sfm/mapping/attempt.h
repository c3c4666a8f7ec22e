// SPDX-License-Identifier: BSD-3-Clause
// An attempt is one way of making models from the photos: by a part of them,
// the plain mapping, one with lower thresholds (map_scene.h) or a repair
// (separate_parts.h). It has what is reported about attempts, and keeps their
// results on disk, so that a killed run does not repeat them.

#ifndef FREEGS_SFM_MAPPING_ATTEMPT_H_
#define FREEGS_SFM_MAPPING_ATTEMPT_H_

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/status.h"
#include "sfm/mapping/step_record.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// What health.json says about an attempt.
struct Attempt {
  std::string name;  // "mapping", "lower thresholds", "small models" ...
  std::string why;   // The reason for trying it; empty for the usual ways.

  int models = 0;  // Number of models that it made.

  // The best of these models; 0 if there is none.
  int registered = 0;        // Photos with a pose.
  size_t points = 0;         // 3D points.
  double mean_error_px = 0;  // Mean reprojection error over observations.

  bool kept = false;    // Its models replaced the ones before.
  std::string problem;  // Why it made no models, or none that were kept.
};

// The report on an attempt that made these models (the best first). kept and
// problem are left for the caller to fill in.
Attempt DescribeAttempt(const std::string& name,
                        const std::string& why,
                        const std::vector<Reconstruction>& models);

// Where models of an attempt replace the first of others: adds those of the
// others behind that share no photo with them.
void AddOthers(const std::vector<Reconstruction>& others,
               std::vector<Reconstruction>* models);

// What an attempt made.
struct AttemptResult {
  std::vector<Reconstruction> models;  // The best first; may be empty.

  // Set by AttemptStore::Try only: the message of the error that ended it.
  std::string problem;

  // The attempts that repaired these models. The store does not keep them.
  std::vector<Attempt> repairs;
};

// Runs each attempt at most once and keeps its result in a folder of its own,
// until Remove() is called:
//
//   AttemptStore store(work_folder, &record);
//   const StatusOr<AttemptResult> result = store.Try("lower thresholds", [&] {
//     return MapWithLowerThresholds(store.Folder("lower thresholds"));
//   });
//
// A later run in the same work folder gets the recorded result at once.
class AttemptStore {
 public:
  AttemptStore(const std::filesystem::path& work_folder, StepRecord* record)
      : folder_(work_folder / "attempts"), record_(record) {}

  // The folder of the attempt of this name. It exists from Run() or Try() on.
  std::filesystem::path Folder(const std::string& name) const;

  // Returns the recorded result of the attempt if there is one. Otherwise makes
  // the attempt's folder anew, calls `run`, which may write there, and records
  // what it returns. An error of `run` is returned and not recorded.
  StatusOr<AttemptResult> Run(
      const std::string& name,
      const std::function<StatusOr<AttemptResult>()>& run);

  // Does what Run does, but an error of `run` becomes a result without models
  // whose `problem` is the message. Such a result is not recorded either. Only
  // kInterrupted and kInternal are still returned as errors.
  StatusOr<AttemptResult> Try(
      const std::string& name,
      const std::function<StatusOr<AttemptResult>()>& run);

  // Deletes the folders of all attempts in a work folder.
  static void Remove(const std::filesystem::path& work_folder);

 private:
  StatusOr<AttemptResult> Read(const std::string& name) const;
  Status Write(const std::string& name, const AttemptResult& result);

  std::filesystem::path folder_;
  StepRecord* record_;
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_ATTEMPT_H_
