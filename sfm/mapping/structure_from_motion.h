// SPDX-License-Identifier: BSD-3-Clause
// Photographs to cameras and points, by running the installed COLMAP step by
// step.

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
#include "sfm/scene/reconstruction.h"
#include "sfm/scene/sfm_photo.h"

namespace freegs::sfm {

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

#endif  // FREEGS_SFM_MAPPING_STRUCTURE_FROM_MOTION_H_
