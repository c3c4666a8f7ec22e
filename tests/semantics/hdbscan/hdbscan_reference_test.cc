// SPDX-License-Identifier: BSD-3-Clause
// Compares with labels and tree weights of scikit-learn-contrib/hdbscan, if the
// environment names the folder that holds them.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/byte_stream.h"
#include "core/io/files.h"
#include "core/kd_tree.h"
#include "semantics/hdbscan/core_distances.h"
#include "semantics/hdbscan/hdbscan.h"
#include "semantics/metrics/adjusted_rand_index.h"
#include "tests/shared_data.h"

namespace freegs::semantics {
namespace {

template <typename T>
std::vector<T> ReadRaw(const std::filesystem::path& path) {
  const auto bytes = ReadFile(path);
  if (!bytes.ok()) return {};
  std::vector<T> values;
  ByteReader(*bytes).GetArray(bytes->size() / sizeof(T), &values);
  return values;
}

nlohmann::json ReadJson(const std::filesystem::path& path) {
  const auto text = ReadFile(path);
  return text.ok() ? nlohmann::json::parse(*text) : nlohmann::json();
}

void CompareSet(const std::filesystem::path& folder, const std::string& set) {
  SCOPED_TRACE(folder.filename().string() + " " + set);
  const nlohmann::json reference =
      ReadJson(folder / ("result_" + set + ".json"));
  ASSERT_TRUE(reference.is_object());
  const std::vector<float> points = ReadRaw<float>(folder / "points.f32");
  const std::vector<int32_t> labels =
      ReadRaw<int32_t>(folder / ("labels_" + set + ".i32"));
  const nlohmann::json& params = reference["params"];
  HdbscanOptions options;
  options.min_cluster_size = params["min_cluster_size"];
  options.min_samples = params["min_samples"];
  options.cluster_selection_epsilon = params["cluster_selection_epsilon"];
  options.max_cluster_size = params["max_cluster_size"];
  options.method = params["cluster_selection_method"] == "leaf"
                       ? ClusterSelection::kLeaf
                       : ClusterSelection::kExcessOfMass;
  ThreadPool pool;
  const auto result =
      Hdbscan(points, reference["d"].get<int>(), options, pool, nullptr);
  ASSERT_TRUE(result.ok()) << result.status().message();
  ASSERT_EQ(result->labels.size(), labels.size());

  // The reference works in double too; `identical` holds rounding noise.
  const double weight = reference["mst_weight"];
  const double core_sum = reference["core_dist_sum"];
  EXPECT_NEAR(
      result->mst_weight, weight, 1e-9 * weight + 1e-5 * (weight < 1e-4));
  const auto tree = KdTree::Build(points, reference["d"].get<int>());
  ASSERT_TRUE(tree.ok());
  const auto cores =
      ComputeCoreDistances(*tree, options.min_samples, pool, nullptr);
  ASSERT_TRUE(cores.ok());
  double found_sum = 0;
  for (const double core2 : cores->core2) found_sum += std::sqrt(core2);
  EXPECT_NEAR(found_sum, core_sum, 1e-9 * core_sum + 1e-5 * (core_sum < 1e-4));
  EXPECT_LE(result->num_clusters, static_cast<int>(labels.size()));
  for (const int32_t label : result->labels) {
    ASSERT_GE(label, -1);
    ASSERT_LT(label, result->num_clusters);
  }
  if (reference["tie_dominated"].get<bool>()) return;

  const nlohmann::json& spread = reference["tie_spread"];
  const double ari = *AdjustedRandIndex(result->labels, labels);
  const int fewest = spread["n_clusters"][0];
  const int most = spread["n_clusters"][1];
  if (set == "leaf20" || set == "epsmax") {
    EXPECT_GE(ari, 0.93);
    EXPECT_GE(result->num_clusters, fewest - std::max(1.0, 0.03 * fewest));
    EXPECT_LE(result->num_clusters, most + std::max(1.0, 0.03 * most));
  } else {
    EXPECT_GE(ari, spread["min_ari"].get<double>() - 0.005);
    EXPECT_GE(result->num_clusters, fewest);
    EXPECT_LE(result->num_clusters, most);
  }
}

class HdbscanReferenceTest : public testing::TestWithParam<const char*> {};

TEST_P(HdbscanReferenceTest, MatchesTheReference) {
  const std::filesystem::path folder =
      SharedData(std::filesystem::path("hdbscan") / GetParam());
  if (folder.empty()) {
    GTEST_SKIP() << "FREEGS_SHARED_DATA has no hdbscan/" << GetParam();
  }
  int compared = 0;
  for (const char* set : {"a20", "b60", "c200", "leaf20", "epsmax"}) {
    if (!std::filesystem::exists(folder /
                                 ("result_" + std::string(set) + ".json"))) {
      continue;
    }
    CompareSet(folder, set);
    ++compared;
  }
  EXPECT_GT(compared, 0) << folder << " has no result";
}

INSTANTIATE_TEST_SUITE_P(Sets,
                         HdbscanReferenceTest,
                         testing::Values("blobs",
                                         "chain",
                                         "identical",
                                         "lattice",
                                         "line",
                                         "moons",
                                         "tiny30",
                                         "scene_small",
                                         "scene_medium",
                                         "scene_large"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace freegs::semantics
