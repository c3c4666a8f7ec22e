// SPDX-License-Identifier: BSD-3-Clause
// Maps a scene by a part of its photos or in the plain way, and again with
// lower thresholds when that leaves photos without a pose.

#ifndef FREEGS_SFM_MAPPING_MAP_SCENE_H_
#define FREEGS_SFM_MAPPING_MAP_SCENE_H_

#include <filesystem>
#include <vector>

#include "core/status.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/diagnosis/diagnosis.h"
#include "sfm/diagnosis/evidence.h"
#include "sfm/mapping/attempt.h"

namespace freegs::sfm {

struct MappedScene {
  std::vector<Reconstruction> models;  // The best first; may be empty.
  SceneEvidence evidence;              // What the matches tell.
  std::vector<Attempt> attempts;       // In the order in which they were made.
  MapperOptions options;               // Those of the attempt that was kept.
};

// The name of the attempt that maps all photos in the plain way.
inline constexpr const char* kPlainMapping = "mapping";

// Maps many photos as MapFromSkeleton does, if they are of one scene and their
// cameras are chosen later, and keeps that if it holds together (view_groups.h)
// and no further attempt below could place more of them. Otherwise maps the
// database as MapFromBestPair does. If there is no model, or too few photos
// have a pose and some of the others match photos of the model, maps it again
// with lower thresholds (weaker start pairs, fewer inliers) and keeps the
// better result: the one with more photos, or with as many and a fifth more
// points that fit as well. A model that look-alikes glued (view_groups.h) never
// replaces one that holds together. If the best model still has fewer than 10
// photos and lacks others, models of 3 photos will do, too. Nothing is tried
// when a finding says that nothing helps.
//
//   AttemptStore store(work_folder, &record);
//   const StatusOr<MappedScene> scene =
//       MapScene(context, work_folder / "database.db", {}, &store);
//
// Errors: those of the plain mapping and of the database, kInterrupted and
// kInternal. Another error of a further attempt is written into its Attempt.
StatusOr<MappedScene> MapScene(const StepContext& context,
                               const std::filesystem::path& database,
                               const DiagnosisOptions& diagnosis,
                               AttemptStore* store);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_MAP_SCENE_H_
