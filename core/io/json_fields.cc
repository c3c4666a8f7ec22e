// SPDX-License-Identifier: BSD-3-Clause

#include "core/io/json_fields.h"

#include <cmath>

#include <Eigen/LU>
#include <nlohmann/json.hpp>

#include "core/number_text.h"

namespace freegs {
namespace {

using nlohmann::json;

// Doubles hold whole numbers up to here without loss.
constexpr double kMaxExact = 9007199254740992.0;

std::string Named(const std::string& source, const std::string& what) {
  return source.empty() ? what : source + ": " + what;
}

Status Fault(const json* value,
             const std::string& where,
             const std::string& expected) {
  return BadInputError(
      Named(where, value == nullptr ? "is missing" : "must be " + expected));
}

// Whether the value is a whole number in [min, max], which `number` becomes.
bool IsWholeNumber(const json& value,
                   int64_t min,
                   int64_t max,
                   int64_t* number) {
  if (value.is_number_unsigned()) {
    const auto large = value.get<uint64_t>();
    if (large > static_cast<uint64_t>(INT64_MAX)) return false;
    *number = static_cast<int64_t>(large);
  } else if (value.is_number_integer()) {
    *number = value.get<int64_t>();
  } else if (value.is_number_float()) {
    const auto real = value.get<double>();
    if (!(std::abs(real) <= kMaxExact) || real != std::floor(real)) {
      return false;
    }
    *number = static_cast<int64_t>(real);
  } else {
    return false;
  }
  return *number >= min && *number <= max;
}

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
    return BadInputError(Named(
        source,
        "nested deeper than " + std::to_string(kMaxJsonDepth) + " levels"));
  }
  if (document.is_discarded()) {
    return BadInputError(Named(source, "not valid JSON"));
  }
  return document;
}

StatusOr<json> ParseJsonObject(std::string_view text,
                               const std::string& source) {
  FREEGS_ASSIGN_OR_RETURN(json document, ParseJson(text, source));
  if (!document.is_object()) {
    return BadInputError(Named(source, "the top level must be an object"));
  }
  return document;
}

const json* FindField(const json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

StatusOr<double> ReadNumber(const json* value, const std::string& where) {
  if (value == nullptr || !value->is_number() ||
      !std::isfinite(value->get<double>())) {
    return Fault(value, where, "a finite number");
  }
  return value->get<double>();
}

StatusOr<double> ReadNumber(const json* value,
                            double min,
                            double max,
                            const std::string& where) {
  if (value == nullptr || !value->is_number() ||
      !(value->get<double>() >= min && value->get<double>() <= max)) {
    return Fault(value,
                 where,
                 "a number in " + FormatSignificant(min, 6) + ".." +
                     FormatSignificant(max, 6));
  }
  return value->get<double>();
}

StatusOr<int64_t> ReadInteger64(const json* value,
                                int64_t min,
                                int64_t max,
                                const std::string& where) {
  int64_t number = 0;
  if (value == nullptr || !IsWholeNumber(*value, min, max, &number)) {
    return Fault(value,
                 where,
                 "a whole number in " + std::to_string(min) + ".." +
                     std::to_string(max));
  }
  return number;
}

StatusOr<int> ReadInteger(const json* value,
                          int min,
                          int max,
                          const std::string& where) {
  FREEGS_ASSIGN_OR_RETURN(const int64_t number,
                          ReadInteger64(value, min, max, where));
  return static_cast<int>(number);
}

StatusOr<bool> ReadBool(const json* value, const std::string& where) {
  if (value == nullptr || !value->is_boolean()) {
    return Fault(value, where, "true or false");
  }
  return value->get<bool>();
}

StatusOr<std::string> ReadText(const json* value, const std::string& where) {
  if (value == nullptr || !value->is_string()) {
    return Fault(value, where, "a text");
  }
  return value->get<std::string>();
}

StatusOr<Eigen::Vector3d> ReadVector3(const json* value,
                                      const std::string& where) {
  if (value == nullptr || !value->is_array() || value->size() != 3) {
    return Fault(value, where, "a list of three numbers");
  }
  Eigen::Vector3d vector;
  for (int i = 0; i < 3; ++i) {
    FREEGS_ASSIGN_OR_RETURN(
        vector[i], ReadNumber(&(*value)[static_cast<size_t>(i)], where));
  }
  return vector;
}

json VectorJson(const Eigen::Vector3d& vector) {
  return json::array({vector.x(), vector.y(), vector.z()});
}

json OrNull(const std::optional<double>& value) {
  return value ? json(*value) : json(nullptr);
}

StatusOr<Eigen::MatrixXd> ReadMatrix(const json* value,
                                     int rows,
                                     int columns,
                                     const std::string& where) {
  const std::string shape =
      std::to_string(rows) + " rows of " + std::to_string(columns) + " numbers";
  if (value == nullptr || !value->is_array() ||
      value->size() != static_cast<size_t>(rows)) {
    return Fault(value, where, shape);
  }
  Eigen::MatrixXd matrix(rows, columns);
  for (int r = 0; r < rows; ++r) {
    const json& row = (*value)[static_cast<size_t>(r)];
    if (!row.is_array() || row.size() != static_cast<size_t>(columns)) {
      return Fault(value, where, shape);
    }
    for (int c = 0; c < columns; ++c) {
      FREEGS_ASSIGN_OR_RETURN(matrix(r, c),
                              ReadNumber(&row[static_cast<size_t>(c)], where));
    }
  }
  return matrix;
}

Status CheckRotation(const Eigen::Matrix3d& rotation,
                     const std::string& where,
                     double tolerance) {
  const Eigen::Matrix3d product = rotation * rotation.transpose();
  // Eigen's maxCoeff() may pass over NaN, so every entry is compared.
  const bool is_orthogonal =
      ((product - Eigen::Matrix3d::Identity()).array().abs() <= tolerance)
          .all();
  if (!is_orthogonal || !(rotation.determinant() > 0)) {
    return BadInputError(Named(where, "not a rotation matrix"));
  }
  return Status();
}

JsonObjectReader::JsonObjectReader(const json& object,
                                   std::string source,
                                   std::string path,
                                   Status* status)
    : object_(object),
      source_(std::move(source)),
      path_(std::move(path)),
      status_(*status) {
  if (!object.is_object()) Fail("", "must be an object");
}

bool JsonObjectReader::IsNull(const char* key) const {
  const json* value = FindField(object_, key);
  return value != nullptr && value->is_null();
}

double JsonObjectReader::Number(const char* key, double min, double max) {
  return Keep(ReadNumber(FindField(object_, key), min, max, Where(key)), 0.0);
}

int JsonObjectReader::Integer(const char* key, int min, int max) {
  return Keep(ReadInteger(FindField(object_, key), min, max, Where(key)), 0);
}

int64_t JsonObjectReader::Integer64(const char* key, int64_t min, int64_t max) {
  return Keep(ReadInteger64(FindField(object_, key), min, max, Where(key)),
              int64_t{0});
}

bool JsonObjectReader::Bool(const char* key) {
  return Keep(ReadBool(FindField(object_, key), Where(key)), false);
}

std::string JsonObjectReader::Text(const char* key) {
  return Keep(ReadText(FindField(object_, key), Where(key)), std::string());
}

Eigen::Vector3d JsonObjectReader::Vector3(const char* key) {
  return Keep(ReadVector3(FindField(object_, key), Where(key)),
              Eigen::Vector3d(Eigen::Vector3d::Zero()));
}

Eigen::MatrixXd JsonObjectReader::Matrix(const char* key,
                                         int rows,
                                         int columns) {
  return Keep(ReadMatrix(FindField(object_, key), rows, columns, Where(key)),
              Eigen::MatrixXd(Eigen::MatrixXd::Zero(rows, columns)));
}

std::map<std::string, std::string> JsonObjectReader::TextMap(const char* key) {
  std::map<std::string, std::string> texts;
  for (const auto& [name, value] : Object(key).items()) {
    texts[name] =
        Keep(ReadText(&value, Where(key) + "." + name), std::string());
  }
  return texts;
}

std::vector<std::string> JsonObjectReader::TextList(const char* key) {
  std::vector<std::string> texts;
  for (const json& value : List(key)) {
    const std::string where =
        Where(key) + "[" + std::to_string(texts.size()) + "]";
    texts.push_back(Keep(ReadText(&value, where), std::string()));
  }
  return texts;
}

const json& JsonObjectReader::List(const char* key) {
  static const json kNothing = json::array();
  const json* value = FindField(object_, key);
  if (status_.ok() && value != nullptr && value->is_array()) return *value;
  Fail(key, value == nullptr ? "is missing" : "must be a list");
  return kNothing;
}

const json& JsonObjectReader::Object(const char* key) {
  static const json kNothing = json::object();
  const json* value = FindField(object_, key);
  if (status_.ok() && value != nullptr && value->is_object()) return *value;
  Fail(key, value == nullptr ? "is missing" : "must be an object");
  return kNothing;
}

void JsonObjectReader::Fail(const std::string& key, const std::string& what) {
  if (status_.ok()) status_ = BadInputError(Named(Where(key), what));
}

std::string JsonObjectReader::Where(const std::string& key) const {
  std::string name = path_;
  if (!name.empty() && !key.empty()) name += ".";
  name += key;
  if (source_.empty() || name.empty()) return source_ + name;
  return source_ + ": " + name;
}

}  // namespace freegs
