// SPDX-License-Identifier: BSD-3-Clause
// Reconstructs cameras and points from photos, by running the installed COLMAP
// step by step and checking what it makes.
//
//   SfmInput input;
//   input.photo_folder = "photos";
//   input.photos = photos;  // Names and sizes, as stage ingest finds them.
//   input.work_folder = "work";
//   StatusOr<SfmResult> result = RunStructureFromMotion(input, SfmOptions());
//   if (!result.ok()) return result.status();
//   TidyWorkFolder(input.work_folder);
//   if (!result->models.empty()) Use(result->models[0]);
//
// Whether the best model is good enough is for health.h to say.

#ifndef FREEGS_SFM_MAPPING_STRUCTURE_FROM_MOTION_H_
#define FREEGS_SFM_MAPPING_STRUCTURE_FROM_MOTION_H_

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/status.h"
#include "sfm/calibration/camera_selection.h"
#include "sfm/colmap/sfm_options.h"
#include "sfm/diagnosis/diagnosis.h"
#include "sfm/mapping/attempt.h"
#include "sfm/matching/pair_selection.h"
#include "sfm/scene/reconstruction.h"
#include "sfm/scene/sfm_photo.h"

namespace freegs::sfm {

struct SfmResult {
  // The models, the best one first: that with most images, and of those with
  // equally many the one with most points. But if that one was glued, its parts
  // come first (see separate_parts.h). May be empty.
  std::vector<Reconstruction> models;

  MatchedPairs pairs;  // The pairs of photos that were compared.

  // Longest side, in pixels, to which photos were reduced before features were
  // taken from them.
  int image_size = 0;

  // So many features of each photo were kept at most.
  int max_features = 0;

  std::vector<Attempt> attempts;  // What was tried, in order.
  std::vector<Finding> findings;  // What was found out, the worst first.

  // The cameras among which that of models[0] was chosen; empty if there was no
  // choice.
  std::vector<CameraCandidate> camera_models;

  std::string colmap_version;
  std::vector<std::string> warnings;

  // For each photo without a pose in models[0], by name: why, as far as the
  // matches tell.
  std::map<std::string, std::string> unregistered;
};

// Runs COLMAP. It is not an error if no model at all comes of it.
//
// Errors: kInvalidArgument (options), kMissingDependency (no usable COLMAP),
// kInterrupted (stopped on request), kBadInput (names, a photo or mask that
// cannot be read, or a damaged database), kUnusableResult (a COLMAP command
// failed; the message has its last lines and names the log), and kInternal (a
// signal ended COLMAP, or a file could not be written, as on a full disk).
// After kInterrupted and kInternal a later call goes on after the last finished
// step.
//
// The same photos, options and seed with the same COLMAP give the same models,
// byte for byte, whatever the number of threads. COLMAP alone does not promise
// this: it numbers photos and draws random numbers in an order that depends on
// its threads. So one thread numbers the photos in a first pass, matches are
// verified in fixed portions with one thread each, and the mapper has one
// thread. See docs/sfm.md.
StatusOr<SfmResult> RunStructureFromMotion(const SfmInput& input,
                                           const SfmOptions& options);

// Deletes what only an interrupted run needs. The database and its list of
// pairs stay, as database.db and pairs.txt.
void TidyWorkFolder(const std::filesystem::path& work_folder);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_STRUCTURE_FROM_MOTION_H_
