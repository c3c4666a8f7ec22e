// SPDX-License-Identifier: BSD-3-Clause
// The file hierarchy.json.

#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_fields.h"
#include "semantics/instances/hierarchy.h"

namespace freegs::semantics {
namespace {

using nlohmann::json;

constexpr size_t kMaxHierarchyFile = size_t{1} << 30;
constexpr double kMaxHeight = 1e9;
constexpr double kMaxPixels = 1e15;
constexpr int kMaxParts = std::numeric_limits<int>::max() / 2;

StatusOr<std::vector<double>> ParseNumbers(const json& list,
                                           double max,
                                           const std::string& where) {
  std::vector<double> numbers;
  for (const json& entry : list) {
    FREEGS_ASSIGN_OR_RETURN(const double number,
                            ReadNumber(&entry, 0, max, where));
    numbers.push_back(number);
  }
  return numbers;
}

StatusOr<RegionTree> ParseTree(const json& list, int num_leaves) {
  RegionTree tree;
  tree.num_leaves = num_leaves;
  std::vector<uint8_t> merged(num_leaves + list.size(), 0);
  for (const json& entry : list) {
    const std::string where =
        "hierarchy: merges[" + std::to_string(tree.merges.size()) + "]";
    if (!entry.is_array() || entry.size() != 3) {
      return BadInputError(where + " must be [region, region, height]");
    }
    const int last = num_leaves + static_cast<int>(tree.merges.size()) - 1;
    RegionTree::Merge merge;
    FREEGS_ASSIGN_OR_RETURN(merge.a, ReadInteger(&entry[0], 0, last, where));
    FREEGS_ASSIGN_OR_RETURN(merge.b, ReadInteger(&entry[1], 0, last, where));
    FREEGS_ASSIGN_OR_RETURN(
        merge.height, ReadNumber(&entry[2], -kMaxHeight, kMaxHeight, where));
    if (merge.a == merge.b || merged[merge.a] != 0 || merged[merge.b] != 0) {
      return BadInputError(where + ": a region is merged twice");
    }
    if (!tree.merges.empty() && merge.height < tree.merges.back().height) {
      return BadInputError(where + ": the heights descend");
    }
    merged[merge.a] = merged[merge.b] = 1;
    tree.merges.push_back(merge);
  }
  return tree;
}

}  // namespace

std::string SerializeHierarchy(const Hierarchy& hierarchy) {
  json merges = json::array();
  for (const RegionTree::Merge& merge : hierarchy.tree.merges) {
    merges.push_back({merge.a, merge.b, merge.height});
  }
  return json({{"granularity", hierarchy.granularity},
               {"total_pixels", hierarchy.total_pixels},
               {"part_pixels", hierarchy.part_pixels},
               {"merges", std::move(merges)},
               {"quality", hierarchy.quality},
               {"part_of_gaussian", hierarchy.part_of_gaussian}})
             .dump() +
         "\n";
}

StatusOr<Hierarchy> ParseHierarchy(std::string_view text) {
  FREEGS_ASSIGN_OR_RETURN(const json document, ParseJsonObject(text));
  Status status;
  JsonObjectReader reader(document, "hierarchy", "", &status);
  Hierarchy hierarchy;
  hierarchy.granularity = reader.Number("granularity", -kMaxHeight, kMaxHeight);
  hierarchy.total_pixels = reader.Number("total_pixels", 0, kMaxPixels);
  const json& pixels = reader.List("part_pixels");
  const json& merges = reader.List("merges");
  const json& quality = reader.List("quality");
  const json& parts = reader.List("part_of_gaussian");
  FREEGS_RETURN_IF_ERROR(status);
  if (!pixels.is_array() || !merges.is_array() || !quality.is_array() ||
      !parts.is_array() || pixels.size() > kMaxParts ||
      merges.size() > pixels.size() ||
      quality.size() != pixels.size() + merges.size()) {
    return BadInputError(
        "hierarchy: part_pixels, merges, quality and part_of_gaussian must be "
        "lists, with fewer merges than parts and a quality for each part and "
        "merge");
  }
  FREEGS_ASSIGN_OR_RETURN(
      hierarchy.part_pixels,
      ParseNumbers(pixels, kMaxPixels, "hierarchy: part_pixels"));
  FREEGS_ASSIGN_OR_RETURN(hierarchy.quality,
                          ParseNumbers(quality, 1, "hierarchy: quality"));
  const int num_leaves = static_cast<int>(pixels.size());
  FREEGS_ASSIGN_OR_RETURN(hierarchy.tree, ParseTree(merges, num_leaves));
  for (const json& entry : parts) {
    FREEGS_ASSIGN_OR_RETURN(
        const int part,
        ReadInteger(&entry, -1, num_leaves - 1, "hierarchy: part_of_gaussian"));
    hierarchy.part_of_gaussian.push_back(part);
  }
  return hierarchy;
}

Status WriteHierarchy(const std::filesystem::path& path,
                      const Hierarchy& hierarchy) {
  return WriteFileAtomic(path, SerializeHierarchy(hierarchy));
}

StatusOr<Hierarchy> ReadHierarchy(const std::filesystem::path& path,
                                  size_t num_gaussians) {
  FREEGS_ASSIGN_OR_RETURN(const std::string text,
                          ReadFile(path, kMaxHierarchyFile));
  StatusOr<Hierarchy> hierarchy = ParseHierarchy(text);
  if (!hierarchy.ok()) return hierarchy.status().Annotated(path.string());
  if (hierarchy->part_of_gaussian.size() != num_gaussians) {
    return BadInputError(path.string() + ": has " +
                         std::to_string(hierarchy->part_of_gaussian.size()) +
                         " Gaussians and the scene has " +
                         std::to_string(num_gaussians) +
                         "; run stage bootstrap again");
  }
  return hierarchy;
}

}  // namespace freegs::semantics
