// SPDX-License-Identifier: BSD-3-Clause
// Reads the mesh of a ScanNet scan (Dai et al. 2017).

#ifndef FREEGS_STAGES_DATASETS_SCANNET_MESH_H_
#define FREEGS_STAGES_DATASETS_SCANNET_MESH_H_

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "core/status.h"
#include "stages/datasets/scannet_objects.h"

namespace freegs::stages {

struct ScannetMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<int> labels;  // NYU40 class of each vertex; may be empty.
  std::vector<std::array<uint32_t, 3>> triangles;
};

// Parses SCAN_vh_clean_2.ply or SCAN_vh_clean_2.labels.ply. Faces that are not
// triangles are left out. kBadInput, naming `source`, for a truncated or
// malformed file, a mesh without vertices, coordinates that are not finite, and
// corners that name no vertex.
StatusOr<ScannetMesh> ParseScannetMesh(std::string_view ply,
                                       const std::string& source);

// What replaces the annotation of objects when it is missing: the connected
// pieces of the mesh that have one label.
struct ScannetPieces {
  std::vector<int64_t> segments;     // The piece of each vertex.
  std::vector<ScannetGroup> groups;  // One group per piece.
};

// Finds the pieces that have at least 50 vertices and a label of NYU40, at most
// 65535 of them, in the order of their first vertices. Things of one class that
// touch become one piece, so the annotation is the better source where it
// exists. kInvalidArgument for a mesh without labels.
StatusOr<ScannetPieces> FindPieces(const ScannetMesh& mesh);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_DATASETS_SCANNET_MESH_H_
