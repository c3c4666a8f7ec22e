// SPDX-License-Identifier: BSD-3-Clause
// ScanNet (Dai et al. 2017): 3D boxes of the objects in a scanned room.

#ifndef FREEGS_STAGES_DATASETS_SCANNET_H_
#define FREEGS_STAGES_DATASETS_SCANNET_H_

#include <filesystem>

#include "core/status.h"
#include "stages/evaluation/ground_truth.h"

namespace freegs::stages {

// Reads a scan, with the frames exported as ScanNet's SensReader does:
//   color/N.jpg (not opened), pose/N.txt      camera to world
//   SCAN.aggregation.json                     objects as sets of segments
//   SCAN_vh_clean_2.0.010000.segs.json        segment of each vertex
//   SCAN_vh_clean_2.ply, or .labels.ply       the vertices
//   SCAN.txt                                  axisAlignment (optional)
// Without SCAN.aggregation.json, objects are the pieces of SCAN_vh_clean_2
// .labels.ply that have one label (see FindPieces).
// All frames with a pose become training views, named N.jpg; lost ones ("-inf")
// are left out, and their cameras are unknown: only poses count. There are
// neither test views nor masks: ScanNet's are too coarse to judge by. The
// truth's frame is the scan's after axisAlignment, in metres. kBadInput says
// what is missing, malformed or does not fit together.
StatusOr<GroundTruth> ReadScannet(const std::filesystem::path& scan);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_DATASETS_SCANNET_H_
