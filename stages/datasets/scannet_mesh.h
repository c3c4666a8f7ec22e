// SPDX-License-Identifier: BSD-3-Clause
// The mesh of a ScanNet scan (Dai et al. 2017).

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
  std::vector<int> labels;  // NYU40 class of each vertex; empty without.
  std::vector<std::array<uint32_t, 3>> triangles;
};

// Parses SCAN_vh_clean_2.ply or SCAN_vh_clean_2.labels.ply. Faces of other than
// three corners are left out. kBadInput names `source` and the fault: truncated
// or malformed, no vertices, coordinates that are not finite, corners that are
// no vertices.
StatusOr<ScannetMesh> ParseScannetMesh(std::string_view ply,
                                       const std::string& source);

// Objects of a labelled mesh whose annotation is lost: pieces of the mesh that
// hang together and have one label.
struct ScannetPieces {
  std::vector<int64_t> segments;     // The piece of each vertex.
  std::vector<ScannetGroup> groups;  // Each of one piece.
};

// Pieces of at least min_vertices whose label is one of NYU40's, at most 65535
// of them, in the order of their first vertices. Things of one class that touch
// are one piece: the annotation is better where there is one. kInvalidArgument
// for a mesh without labels.
StatusOr<ScannetPieces> FindPieces(const ScannetMesh& mesh);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_DATASETS_SCANNET_MESH_H_
