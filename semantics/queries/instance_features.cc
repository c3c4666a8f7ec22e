// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/queries/instance_features.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_fields.h"
#include "core/io/json_text.h"

namespace freegs::semantics {
namespace {

using nlohmann::json;

// 100000 instances of 768 numbers, at about 21 bytes each. Reading takes memory
// in proportion to the file.
constexpr uint64_t kMaxFileSize = uint64_t{1} << 31;
constexpr int kMaxDim = 1 << 16;
// How far a vector of length 1 may be off by rounding.
constexpr double kLengthTolerance = 1e-3;

// What is wrong with row i, or OK.
Status CheckRow(std::span<const float> row, size_t i) {
  double square = 0;
  for (const float value : row) square += static_cast<double>(value) * value;
  if (square == 0) return Status();
  if (!(std::abs(std::sqrt(square) - 1) <= kLengthTolerance)) {
    return BadInputError("the feature of instance " + std::to_string(i + 1) +
                         " has neither length 1 nor 0");
  }
  return Status();
}

}  // namespace

bool InstanceFeatures::known(size_t i) const {
  const std::span<const float> values = row(i);
  return std::any_of(
      values.begin(), values.end(), [](float value) { return value != 0; });
}

StatusOr<std::string> SerializeInstanceFeatures(
    const InstanceFeatures& features) {
  if (features.dim < 1 || features.dim > kMaxDim ||
      features.features.size() % static_cast<size_t>(features.dim) != 0) {
    return InvalidArgumentError(std::to_string(features.features.size()) +
                                " numbers are no instance features of " +
                                std::to_string(features.dim));
  }
  json rows = json::array();
  for (size_t i = 0; i < features.size(); ++i) {
    const std::span<const float> row = features.row(i);
    const Status good = CheckRow(row, i);
    if (!good.ok()) return InvalidArgumentError(good.message());
    rows.push_back(json(std::vector<float>(row.begin(), row.end())));
  }
  const json file = {{"model", features.model},
                     {"model_hash", features.model_hash},
                     {"dim", features.dim},
                     {"features", std::move(rows)}};
  // A folder's name need not be UTF-8.
  return JsonText(file, -1);
}

Status WriteInstanceFeatures(const std::filesystem::path& path,
                             const InstanceFeatures& features) {
  FREEGS_ASSIGN_OR_RETURN(const std::string text,
                          SerializeInstanceFeatures(features));
  return WriteFileAtomic(path, text);
}

StatusOr<InstanceFeatures> ParseInstanceFeatures(std::string_view text) {
  FREEGS_ASSIGN_OR_RETURN(const json file, ParseJsonObject(text));
  Status status;
  JsonObjectReader reader(file, "", "", &status);
  InstanceFeatures features;
  features.model = reader.Text("model");
  features.model_hash = reader.Text("model_hash");
  features.dim = reader.Integer("dim", 1, kMaxDim);
  const json& rows = reader.List("features");
  FREEGS_RETURN_IF_ERROR(status);
  for (const json& row : rows) {
    const size_t i = features.size();
    if (!row.is_array() || row.size() != static_cast<size_t>(features.dim)) {
      return BadInputError("the feature of instance " + std::to_string(i + 1) +
                           " is not a list of " + std::to_string(features.dim) +
                           " numbers");
    }
    for (const json& value : row) {
      if (!value.is_number()) {
        return BadInputError("the feature of instance " +
                             std::to_string(i + 1) + " is not all numbers");
      }
      features.features.push_back(value.get<float>());
    }
    FREEGS_RETURN_IF_ERROR(CheckRow(features.row(i), i));
  }
  return features;
}

StatusOr<InstanceFeatures> ReadInstanceFeatures(
    const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string text, ReadFile(path, kMaxFileSize));
  auto features = ParseInstanceFeatures(text);
  if (features.ok()) return features;
  return BadInputError(path.string() + ": " + features.status().message() +
                       "; run stage bootstrap again");
}

}  // namespace freegs::semantics
