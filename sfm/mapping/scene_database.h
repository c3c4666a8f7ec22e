// SPDX-License-Identifier: BSD-3-Clause
// COLMAP's database of a scene: its photos, their features and matches.

#ifndef FREEGS_SFM_MAPPING_SCENE_DATABASE_H_
#define FREEGS_SFM_MAPPING_SCENE_DATABASE_H_

#include <filesystem>
#include <memory>

#include "core/status.h"
#include "sfm/colmap/colmap_program.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/colmap/sfm_options.h"
#include "sfm/mapping/step_record.h"

namespace freegs::sfm {

// The database in a work folder, and what further steps need:
//
//   FREEGS_ASSIGN_OR_RETURN(const std::unique_ptr<SceneDatabase> scene,
//                           SceneDatabase::Build(input, options));
//   MapFromBestPair(scene->context(), scene->path(), folder);
class SceneDatabase {
 public:
  // Finds COLMAP, and fills database.db in the work folder with the photos,
  // their features and matches. Steps that an earlier call finished are not
  // repeated. `input` must outlive the result.
  //
  // Errors: kInvalidArgument (options), kMissingDependency (no usable COLMAP),
  // kInterrupted (stopped on request), kBadInput (names, a photo or mask that
  // cannot be read, or a damaged database), kUnusableResult (a COLMAP command
  // failed), and kInternal (a signal ended COLMAP, or a file could not be
  // written, as on a full disk). After kInterrupted and kInternal a later call
  // goes on after the last finished step.
  static StatusOr<std::unique_ptr<SceneDatabase>> Build(
      const SfmInput& input, const SfmOptions& options);

  SceneDatabase(const SceneDatabase&) = delete;
  SceneDatabase& operator=(const SceneDatabase&) = delete;

  // The options in it have the image size that was chosen.
  const StepContext& context() const { return context_; }
  const std::filesystem::path& path() const { return path_; }
  StepRecord& record() { return record_; }

 private:
  SceneDatabase(const SfmInput& input,
                const SfmOptions& options,
                ColmapProgram colmap);
  Status ChooseSize();
  Status Fill();

  SfmOptions options_;
  ColmapProgram colmap_;
  StepContext context_;  // Refers to options_ and colmap_.
  std::filesystem::path path_;
  StepRecord record_;
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_SCENE_DATABASE_H_
