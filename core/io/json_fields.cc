// SPDX-License-Identifier: BSD-3-Clause

#include "core/io/json_fields.h"

#include <cmath>

#include <Eigen/LU>
#include <nlohmann/json.hpp>

namespace freegs {
namespace {

using nlohmann::json;

constexpr double kRotationTolerance = 1e-3;

}  // namespace

StatusOr<json> ParseJson(std::string_view text, const std::string& source) {
  bool too_deep = false;
  json document = json::parse(
      text,
      [&too_deep](int depth, json::parse_event_t, json&) {
        // What lies deeper is dropped while parsing, so it takes no memory.
        too_deep = too_deep || depth > kMaxJsonDepth;
        return !too_deep;
      },
      /*allow_exceptions=*/false);
  if (too_deep) {
    return BadInputError(source + ": nested deeper than " +
                         std::to_string(kMaxJsonDepth) + " levels");
  }
  if (document.is_discarded()) {
    return BadInputError(source + ": not valid JSON");
  }
  return document;
}

StatusOr<json> ParseJsonObject(std::string_view text,
                               const std::string& source) {
  FREEGS_ASSIGN_OR_RETURN(json document, ParseJson(text, source));
  if (!document.is_object()) {
    return BadInputError(source + ": the top level must be an object");
  }
  return document;
}

const json* FindField(const json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

StatusOr<double> ReadNumber(const json* value, const std::string& where) {
  if (value == nullptr || !value->is_number()) {
    return BadInputError(where + ": must be a number");
  }
  const double number = value->get<double>();
  if (!std::isfinite(number)) {
    return BadInputError(where + ": must be finite");
  }
  return number;
}

StatusOr<int> ReadInteger(const json* value,
                          int min,
                          int max,
                          const std::string& where) {
  FREEGS_ASSIGN_OR_RETURN(const double number, ReadNumber(value, where));
  if (number < min || number > max || number != std::floor(number)) {
    return BadInputError(where + ": must be a whole number in " +
                         std::to_string(min) + ".." + std::to_string(max));
  }
  return static_cast<int>(number);
}

StatusOr<std::string> ReadText(const json* value, const std::string& where) {
  if (value == nullptr || !value->is_string()) {
    return BadInputError(where + ": must be a text");
  }
  return value->get<std::string>();
}

StatusOr<Eigen::Vector3d> ReadVector3(const json* value,
                                      const std::string& where) {
  if (value == nullptr || !value->is_array() || value->size() != 3) {
    return BadInputError(where + ": must be a list of three numbers");
  }
  Eigen::Vector3d vector;
  for (int i = 0; i < 3; ++i) {
    FREEGS_ASSIGN_OR_RETURN(
        vector[i], ReadNumber(&(*value)[static_cast<size_t>(i)], where));
  }
  return vector;
}

StatusOr<Eigen::MatrixXd> ReadMatrix(const json* value,
                                     int rows,
                                     int columns,
                                     const std::string& where) {
  const std::string shape = where + ": must be " + std::to_string(rows) +
                            " rows of " + std::to_string(columns) + " numbers";
  if (value == nullptr || !value->is_array() ||
      value->size() != static_cast<size_t>(rows)) {
    return BadInputError(shape);
  }
  Eigen::MatrixXd matrix(rows, columns);
  for (int r = 0; r < rows; ++r) {
    const json& row = (*value)[static_cast<size_t>(r)];
    if (!row.is_array() || row.size() != static_cast<size_t>(columns)) {
      return BadInputError(shape);
    }
    for (int c = 0; c < columns; ++c) {
      FREEGS_ASSIGN_OR_RETURN(matrix(r, c),
                              ReadNumber(&row[static_cast<size_t>(c)], where));
    }
  }
  return matrix;
}

Status CheckRotation(const Eigen::Matrix3d& rotation,
                     const std::string& where) {
  const Eigen::Matrix3d product = rotation * rotation.transpose();
  if (!((product - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <=
        kRotationTolerance) ||
      rotation.determinant() < 0) {
    return BadInputError(where + ": not a rotation matrix");
  }
  return Status();
}

}  // namespace freegs
