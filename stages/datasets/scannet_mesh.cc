// SPDX-License-Identifier: BSD-3-Clause

#include "stages/datasets/scannet_mesh.h"

#include <cmath>
#include <optional>
#include <unordered_map>
#include <utility>

#include "core/disjoint_sets.h"
#include "splat/scene/ply_header.h"

namespace freegs::stages {
namespace {

using Eigen::Vector3d;
using splat::PlyElement;
using splat::PlyProperty;
using splat::PlyValueReader;

constexpr size_t kMaxPieces = 65535;

// Smaller pieces are scraps of the scan rather than objects.
constexpr int64_t kMinVertices = 50;

// The classes of NYU40 (Gupta et al. 2013); the first one is class 1.
constexpr std::array<const char*, 40> kClasses = {"wall",
                                                  "floor",
                                                  "cabinet",
                                                  "bed",
                                                  "chair",
                                                  "sofa",
                                                  "table",
                                                  "door",
                                                  "window",
                                                  "bookshelf",
                                                  "picture",
                                                  "counter",
                                                  "blinds",
                                                  "desk",
                                                  "shelves",
                                                  "curtain",
                                                  "dresser",
                                                  "pillow",
                                                  "mirror",
                                                  "floor mat",
                                                  "clothes",
                                                  "ceiling",
                                                  "books",
                                                  "refrigerator",
                                                  "television",
                                                  "paper",
                                                  "towel",
                                                  "shower curtain",
                                                  "box",
                                                  "whiteboard",
                                                  "person",
                                                  "nightstand",
                                                  "toilet",
                                                  "sink",
                                                  "lamp",
                                                  "bathtub",
                                                  "bag",
                                                  "other structure",
                                                  "other furniture",
                                                  "other prop"};

Status Truncated(const std::string& source, const std::string& where) {
  return BadInputError(source + ": ends, or is malformed, in its " + where);
}

// The index of a property in the element. Nothing when the element has no such
// property or when it is a list.
std::optional<size_t> Find(const PlyElement& element, const char* name) {
  for (size_t i = 0; i < element.properties.size(); ++i) {
    const PlyProperty& property = element.properties[i];
    if (property.name == name && !property.is_list) return i;
  }
  return std::nullopt;
}

Status ReadVertices(const PlyElement& element,
                    splat::PlyFormat format,
                    const std::string& source,
                    PlyValueReader* reader,
                    ScannetMesh* mesh) {
  const std::array<std::optional<size_t>, 3> axes = {
      Find(element, "x"), Find(element, "y"), Find(element, "z")};
  if (!axes[0] || !axes[1] || !axes[2]) {
    return BadInputError(source + ": vertices without x, y and z");
  }
  const std::optional<size_t> label = Find(element, "label");
  // The header may promise more than the file holds.
  if (element.count >
      reader->remaining_bytes() / element.MinItemBytes(format)) {
    return BadInputError(source + ": is too short for its " +
                         std::to_string(element.count) + " vertices");
  }
  mesh->vertices.resize(element.count);
  if (label) mesh->labels.resize(element.count);
  for (size_t v = 0; v < element.count; ++v) {
    for (size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      double value = 0;
      const bool read = property.is_list ? reader->Skip(property)
                                         : reader->Read(property.type, &value);
      if (!read) return Truncated(source, "vertices");
      for (int axis = 0; axis < 3; ++axis) {
        if (axes[static_cast<size_t>(axis)] == i) {
          mesh->vertices[v][axis] = value;
        }
      }
      // A label that is not a whole number is no class.
      if (label == i) {
        mesh->labels[v] =
            value >= 0 && value <= 65535 && value == std::floor(value)
                ? static_cast<int>(value)
                : -1;
      }
    }
    if (!mesh->vertices[v].allFinite()) {
      return BadInputError(source + ": a vertex is not finite");
    }
  }
  return Status();
}

// Reads a face. *corners is empty when it has other than three corners. Returns
// false when the data end too early.
bool ReadFace(const PlyProperty& property,
              PlyValueReader* reader,
              std::optional<std::array<double, 3>>* corners) {
  double count = 0;
  if (!reader->Read(property.count_type, &count) || !(count >= 0)) return false;
  std::array<double, 3> values = {};
  for (double k = 0; k < count; ++k) {
    double value = 0;
    if (!reader->Read(property.type, &value)) return false;
    if (k < 3) values[static_cast<size_t>(k)] = value;
  }
  corners->reset();
  if (count == 3) *corners = values;
  return true;
}

Status ReadFaces(const PlyElement& element,
                 const std::string& source,
                 PlyValueReader* reader,
                 ScannetMesh* mesh) {
  if (element.properties.empty()) return Status();
  const auto num_vertices = static_cast<double>(mesh->vertices.size());
  for (uint64_t f = 0; f < element.count; ++f) {
    for (const PlyProperty& property : element.properties) {
      const bool is_corners =
          property.is_list && (property.name == "vertex_indices" ||
                               property.name == "vertex_index");
      std::optional<std::array<double, 3>> corners;
      if (!(is_corners ? ReadFace(property, reader, &corners)
                       : reader->Skip(property))) {
        return Truncated(source, "faces");
      }
      if (!corners) continue;
      std::array<uint32_t, 3> triangle = {};
      for (size_t k = 0; k < 3; ++k) {
        const double corner = (*corners)[k];
        if (!(corner >= 0 && corner < num_vertices)) {
          return BadInputError(source +
                               ": a face has a corner that is no "
                               "vertex");
        }
        triangle[k] = static_cast<uint32_t>(corner);
      }
      mesh->triangles.push_back(triangle);
    }
  }
  return Status();
}

// For each vertex the smallest vertex of its piece.
std::vector<uint32_t> Roots(const ScannetMesh& mesh) {
  DisjointSets pieces(mesh.vertices.size());
  for (const auto& triangle : mesh.triangles) {
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t a = triangle[k];
      const uint32_t b = triangle[(k + 1) % 3];
      if (mesh.labels[a] == mesh.labels[b]) pieces.Join(a, b);
    }
  }
  std::vector<uint32_t> roots(pieces.size());
  for (uint32_t v = 0; v < roots.size(); ++v) roots[v] = pieces.Find(v);
  return roots;
}

}  // namespace

StatusOr<ScannetMesh> ParseScannetMesh(std::string_view ply,
                                       const std::string& source) {
  const StatusOr<splat::PlyHeader> header = splat::ParsePlyHeader(ply);
  if (!header.ok()) return header.status().Annotated(source);
  PlyValueReader reader(header->format, ply.substr(header->size));
  ScannetMesh mesh;
  for (const PlyElement& element : header->elements) {
    if (element.name == "vertex") {
      FREEGS_RETURN_IF_ERROR(
          ReadVertices(element, header->format, source, &reader, &mesh));
    } else {
      FREEGS_RETURN_IF_ERROR(ReadFaces(element, source, &reader, &mesh));
    }
  }
  if (mesh.vertices.empty()) {
    return BadInputError(source + ": holds no vertices");
  }
  return mesh;
}

StatusOr<ScannetPieces> FindPieces(const ScannetMesh& mesh) {
  if (mesh.labels.size() != mesh.vertices.size()) {
    return InvalidArgumentError("a mesh without labels");
  }
  const std::vector<uint32_t> roots = Roots(mesh);
  ScannetPieces pieces;
  pieces.segments.assign(roots.begin(), roots.end());
  std::unordered_map<uint32_t, int64_t> sizes;
  for (const uint32_t root : roots) ++sizes[root];
  for (uint32_t v = 0; v < roots.size(); ++v) {
    const int label = mesh.labels[v];
    if (roots[v] != v || sizes[v] < kMinVertices || label < 1 ||
        label > static_cast<int>(kClasses.size())) {
      continue;
    }
    if (pieces.groups.size() == kMaxPieces) break;
    ScannetGroup group;
    group.id = static_cast<int>(pieces.groups.size()) + 1;
    group.label = kClasses[static_cast<size_t>(label - 1)];
    group.segments = {static_cast<int64_t>(v)};
    pieces.groups.push_back(std::move(group));
  }
  return pieces;
}

}  // namespace freegs::stages
