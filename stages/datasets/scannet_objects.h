// SPDX-License-Identifier: BSD-3-Clause
// Reads the annotated objects of a ScanNet scan (Dai et al. 2017) as boxes.

#ifndef FREEGS_STAGES_DATASETS_SCANNET_OBJECTS_H_
#define FREEGS_STAGES_DATASETS_SCANNET_OBJECTS_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "core/status.h"
#include "stages/evaluation/ground_truth.h"

namespace freegs::stages {

// The parsers below return kBadInput, naming `source` and the fault, for
// truncated or malformed text and for numbers that are out of range or not
// finite.

// Parses the segment of each vertex: "segIndices" of
// SCAN_vh_clean_2.0.010000.segs.json.
StatusOr<std::vector<int64_t>> ParseScannetSegments(std::string_view json,
                                                    const std::string& source);

// An object as a set of segments: "segGroups" of SCAN.aggregation.json.
struct ScannetGroup {
  int id = 0;  // objectId + 1.
  std::string label;
  std::vector<int64_t> segments;
};
StatusOr<std::vector<ScannetGroup>> ParseScannetGroups(
    std::string_view json, const std::string& source);

// Parses "axisAlignment = 16 numbers" of SCAN.txt: the rows of the matrix that
// turns walls and floor parallel to the axes. Returns the identity when there
// is no such line; kBadInput when it is not a rotation and a translation.
StatusOr<Eigen::Matrix4d> ParseScannetAlignment(std::string_view text,
                                                const std::string& source);

// Puts a box around the vertices of each group, axis-aligned after `alignment`,
// and returns the objects by ascending id. Walls, floors, ceilings and groups
// without a vertex are left out. kInvalidArgument when `segments` and
// `vertices` differ in length.
StatusOr<std::vector<TrueObject>> ScannetBoxes(
    const std::vector<Eigen::Vector3d>& vertices,
    const std::vector<int64_t>& segments,
    const std::vector<ScannetGroup>& groups,
    const Eigen::Matrix4d& alignment);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_DATASETS_SCANNET_OBJECTS_H_
