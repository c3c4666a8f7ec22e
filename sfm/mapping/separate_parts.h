// SPDX-License-Identifier: BSD-3-Clause
// Repairs models in which parts of the scene that look alike were glued
// together (see view_groups.h), or takes them apart.

#ifndef FREEGS_SFM_MAPPING_SEPARATE_PARTS_H_
#define FREEGS_SFM_MAPPING_SEPARATE_PARTS_H_

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/status.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/mapping/attempt.h"

namespace freegs::sfm {

struct SeparatedParts {
  // The score of the first model given (see ViewGroups), and in how many groups
  // of photos it falls.
  double score = 1;
  size_t groups = 1;

  // The models to be used instead of those given: one that holds together, or
  // the parts into which the best one was taken apart, the largest first. Then
  // follow those given, but for the first, that share no photo with these.
  // Empty if the first model given holds together and nothing needs to be done.
  std::vector<Reconstruction> models;

  // Names of the photos that the first model given has and models[0] lacks,
  // ascending. Where they belong is unknown.
  std::vector<std::string> unplaced;

  std::vector<Attempt> attempts;  // How it was repaired, in this order.
};

// Checks models[0] against all verified matches of the database. If it is
// glued and has 50 photos or more, takes the photos outside of its largest
// group out and places them again, without the pairs of photos that glued it.
// If that does not give a model that holds together, maps all photos anew
// without these pairs. Each is done up to three times. Of all models it takes
// the one with the largest consistent group, and takes it apart: each group of
// three photos or more becomes a model.
//
// `models` are the best first; there may be none, and only the first is
// checked. Mapping anew begins with the best pair after `skip` others; `suffix`
// is added to the names of the attempts.
//
// Errors: those of the database, kInterrupted and kInternal. Another error of
// COLMAP is written into its Attempt.
StatusOr<SeparatedParts> SeparateParts(
    const StepContext& context,
    const std::filesystem::path& database,
    const std::vector<Reconstruction>& models,
    AttemptStore* store,
    size_t skip = 0,
    const std::string& suffix = "");

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_SEPARATE_PARTS_H_
