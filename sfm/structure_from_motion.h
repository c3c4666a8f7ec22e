// SPDX-License-Identifier: BSD-3-Clause
// Photographs to cameras and points, by running the installed COLMAP step by
// step.

#ifndef FREEGS_SFM_STRUCTURE_FROM_MOTION_H_
#define FREEGS_SFM_STRUCTURE_FROM_MOTION_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/status.h"
#include "sfm/attempt.h"
#include "sfm/camera_selection.h"
#include "sfm/diagnosis.h"
#include "sfm/pair_selection.h"
#include "sfm/reconstruction.h"

namespace freegs::sfm {

// A photo to be posed.
struct SfmPhoto {
  std::string name;      // File, relative to the photo folder.
  std::string file;      // As the user knows it, if that is another name.
  int width = 0;         // Pixels.
  int height = 0;        // Pixels.
  int camera_group = 0;  // Photos of equal number may share one camera.
  double focal_px = 0;   // What EXIF says; 0 when it says nothing.
  double sharpness = 0;  // As ingest measured it; 0 is unknown.
};

struct SfmOptions {
  // The COLMAP program: a path, or a name in PATH.
  std::string colmap = "colmap";

  // Which photos share intrinsics: "auto" (those of a camera group), "single"
  // (all of one size), or "per_image" (none).
  std::string camera = "auto";

  // COLMAP's name of the lens model to estimate; or "auto": COLMAP estimates
  // RADIAL, then the best model is adjusted with the simplest cameras that
  // explain its tracks (camera_selection.h).
  std::string camera_model = "auto";

  // Longest side, in pixels, of the images that features are taken from; 0
  // takes the smallest, from 800 to 1600, that is enough for max_features.
  int max_image_size = 0;

  // Features kept per photo (those of the largest scale).
  int max_features = 3000;

  // Which pairs of photos are matched.
  PairSelectionOptions pairs;

  // What all attempts beyond the first may cost together, as a multiple of what
  // the first did, when it leaves out photos. 0 for no other attempts.
  double max_retry_cost = 8;

  // Features on the graphics card (COLMAP must have been built for it).
  bool use_gpu = false;

  // Threads and parallel programs; <= 0 takes one per core. Changes nothing
  // about the result.
  int num_threads = 0;

  // What COLMAP is asked to estimate.
  const char* ColmapCameraModel() const {
    return camera_model == "auto" ? "RADIAL" : camera_model.c_str();
  }

  Status Check() const;
};

struct SfmInput {
  std::filesystem::path photo_folder;
  std::vector<SfmPhoto> photos;  // In the order in which they were taken.

  // Masks, as NAME.png for the photo NAME: features where they are 0 are not
  // taken. Every photo has one (newer releases of COLMAP skip photos without).
  // Empty for none.
  std::filesystem::path mask_folder;

  // Where the steps leave their files: database.db, logs/, steps.json. Calling
  // again with the same input and options continues after the last finished
  // step, whatever ended the earlier call.
  std::filesystem::path work_folder;

  uint64_t seed = 0;
  const CancellationToken* cancellation = nullptr;
  ProgressFn progress;
};

struct SfmResult {
  // The reconstructions that COLMAP made; the one with most images, then most
  // points, first. May be empty.
  std::vector<Reconstruction> models;

  // Strongest matches that models[0] contradicts (see view_graph.h).
  size_t contradictions = 0;

  // The database that models were made from: that of the work folder, or of an
  // attempt (see TidyWorkFolder).
  MatchedDatabase database;

  // What was tried, in order, and what was found out about the photos.
  std::vector<Attempt> attempts;
  std::vector<Finding> findings;

  // The cameras tried for models[0]; empty when there was no choice to make.
  std::vector<CameraCandidate> camera_models;

  std::string colmap_version;
  std::vector<std::string> warnings;

  // For photos not in models[0]: why, as far as the matches tell.
  std::map<std::string, std::string> unregistered;
};

// Runs COLMAP. Finding no model at all is not an error here (see health.h).
// Errors: kMissingDependency (no usable COLMAP), kInterrupted (finished steps
// are kept), kBadInput, kUnusableResult (a COLMAP command failed; the message
// has its last lines and names the log).
//
// Repeatable: the same photos, options and seed with the same COLMAP give the
// same models, byte for byte, whatever the number of threads. COLMAP itself
// numbers photos, and draws random numbers, in an order that depends on its
// threads; so photos are numbered in a first pass by one thread, matching runs
// in fixed portions of one thread each, several at a time, and so does the
// mapper. See docs/sfm.md.
StatusOr<SfmResult> RunStructureFromMotion(const SfmInput& input,
                                           const SfmOptions& options);

// Deletes what only an interrupted run needs from the work folder, and leaves
// the database of the result there as database.db.
Status TidyWorkFolder(const std::filesystem::path& work_folder,
                      const SfmResult& result);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_STRUCTURE_FROM_MOTION_H_
