// SPDX-License-Identifier: BSD-3-Clause
// How well the regions of a scene meet its true objects.

#ifndef FREEGS_BENCH_EVIDENCE_SEGMENTATION_QUALITY_H_
#define FREEGS_BENCH_EVIDENCE_SEGMENTATION_QUALITY_H_

#include <cstdint>
#include <map>
#include <vector>

#include "bench/evidence/learning_scene.h"
#include "semantics/instances/hierarchy.h"

namespace freegs::evidence {

// A true object, in all views together.
struct ObjectQuality {
  int id = 0;
  double pixels = 0;
  double iou = 0;  // With the region that meets it best.
  int pieces = 0;  // Regions that each have a tenth of it or more.
  int32_t region = -1;
  std::map<int, double> in_region;  // Pixels of segments in that region.
};

// region_of_patch: -1 for none.
std::vector<ObjectQuality> MeasureObjects(
    const LearningScene& scene, const std::vector<int32_t>& region_of_patch);

double MeanIou(const std::vector<ObjectQuality>& objects);
double MeanPieces(const std::vector<ObjectQuality>& objects);

// The mean IoU with the region of the tree that meets each object best.
double BestLevelIou(const LearningScene& scene,
                    const semantics::RegionTree& tree);

// The mean IoU with all patches that are mostly in the object.
double BestPatchesIou(const LearningScene& scene);

}  // namespace freegs::evidence

#endif  // FREEGS_BENCH_EVIDENCE_SEGMENTATION_QUALITY_H_
