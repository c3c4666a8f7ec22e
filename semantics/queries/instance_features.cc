// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/queries/instance_features.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/files.h"

namespace freegs::semantics {
namespace {

using nlohmann::json;

// 5000 instances of 768 numbers; parsed, about as much again.
constexpr uint64_t kMaxFileSize = uint64_t{1} << 27;
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

// Null where there is no such member.
const json* Member(const json& object, const char* name) {
  const auto it = object.find(name);
  return it == object.end() ? nullptr : &*it;
}

Status ReadText(const json& object, const char* name, std::string* text) {
  const json* member = Member(object, name);
  if (member == nullptr || !member->is_string()) {
    return BadInputError(std::string("\"") + name +
                         "\" is missing or not a text");
  }
  *text = member->get<std::string>();
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
  return file.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

Status WriteInstanceFeatures(const std::filesystem::path& path,
                             const InstanceFeatures& features) {
  FREEGS_ASSIGN_OR_RETURN(const std::string text,
                          SerializeInstanceFeatures(features));
  return WriteFileAtomic(path, text);
}

StatusOr<InstanceFeatures> ParseInstanceFeatures(std::string_view text) {
  const json file = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!file.is_object()) {
    return BadInputError(
        "this is not a file of instance features in JSON; run stage bootstrap "
        "again");
  }
  InstanceFeatures features;
  FREEGS_RETURN_IF_ERROR(ReadText(file, "model", &features.model));
  FREEGS_RETURN_IF_ERROR(ReadText(file, "model_hash", &features.model_hash));
  const json* dim = Member(file, "dim");
  if (dim == nullptr || !dim->is_number_integer() || *dim < 1 ||
      *dim > kMaxDim) {
    return BadInputError("\"dim\" is missing or not a number from 1 to " +
                         std::to_string(kMaxDim));
  }
  features.dim = dim->get<int>();
  const json* rows = Member(file, "features");
  if (rows == nullptr || !rows->is_array()) {
    return BadInputError("\"features\" is missing or not a list");
  }
  for (const json& row : *rows) {
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
  if (!features.ok()) return features.status().Annotated(path.string());
  return features;
}

}  // namespace freegs::semantics
