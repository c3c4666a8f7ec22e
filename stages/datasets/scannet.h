// SPDX-License-Identifier: BSD-3-Clause
// Reads scans of ScanNet (Dai et al., "ScanNet: Richly-annotated 3D
// Reconstructions of Indoor Scenes", 2017): 3D boxes of the objects in a room.

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
// Without SCAN.aggregation.json the objects are the connected pieces of one
// label in SCAN_vh_clean_2.labels.ply (see FindPieces).
//
// All frames with a pose become training views named N.jpg; frames whose pose
// is lost ("-inf") are left out. The intrinsics of these views are not set,
// because they only serve to align poses. There are neither test views nor
// masks: ScanNet's masks are too coarse to judge by. The truth's frame is that
// of the scan after axisAlignment, in metres. kBadInput says what is missing,
// malformed or does not fit together.
StatusOr<GroundTruth> ReadScannet(const std::filesystem::path& scan);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_DATASETS_SCANNET_H_
