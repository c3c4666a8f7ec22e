// SPDX-License-Identifier: BSD-3-Clause
// Reads JSON that somebody else may have written. Every fault becomes
// kBadInput, and the message names the file, the entry, and what was expected
// there.

#ifndef FREEGS_CORE_IO_JSON_FIELDS_H_
#define FREEGS_CORE_IO_JSON_FIELDS_H_

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "core/status.h"

namespace freegs {

// Objects and lists may be nested to this depth. No file of the program needs
// more, and code that walks or frees a document recurses once per level.
inline constexpr int kMaxJsonDepth = 64;

// Parses a document. `source` names it in messages, usually by its path; it may
// be empty when the caller adds the name.
StatusOr<nlohmann::json> ParseJson(std::string_view text,
                                   const std::string& source = "");

// Does the same for a document whose top level must be an object.
StatusOr<nlohmann::json> ParseJsonObject(std::string_view text,
                                         const std::string& source = "");

// Returns the member `key`, or null when there is none or when `object` is not
// an object.
const nlohmann::json* FindField(const nlohmann::json& object, const char* key);

// Each of the following functions reads one value. `value` may be null, which
// means that it is missing and is a fault too. The message begins with `where`,
// such as "cameras.json: intrinsics.fx".

// Reads a finite number.
StatusOr<double> ReadNumber(const nlohmann::json* value,
                            const std::string& where);

// Reads a number in [min, max].
StatusOr<double> ReadNumber(const nlohmann::json* value,
                            double min,
                            double max,
                            const std::string& where);

// Reads a whole number in [min, max]. It may be written as 3 or as 3.0.
StatusOr<int> ReadInteger(const nlohmann::json* value,
                          int min,
                          int max,
                          const std::string& where);
StatusOr<int64_t> ReadInteger64(const nlohmann::json* value,
                                int64_t min,
                                int64_t max,
                                const std::string& where);

// Reads true or false.
StatusOr<bool> ReadBool(const nlohmann::json* value, const std::string& where);

// Reads a text, which may be empty.
StatusOr<std::string> ReadText(const nlohmann::json* value,
                               const std::string& where);

// Reads a list of three finite numbers.
StatusOr<Eigen::Vector3d> ReadVector3(const nlohmann::json* value,
                                      const std::string& where);

// The list that ReadVector3 reads.
nlohmann::json VectorJson(const Eigen::Vector3d& vector);

// The number, or null.
nlohmann::json OrNull(const std::optional<double>& value);

// Reads a list of `rows` lists of `columns` finite numbers.
StatusOr<Eigen::MatrixXd> ReadMatrix(const nlohmann::json* value,
                                     int rows,
                                     int columns,
                                     const std::string& where);

// Returns kBadInput unless the determinant of R is positive and every entry of
// R R^T is within `tolerance` of the identity's.
Status CheckRotation(const Eigen::Matrix3d& rotation,
                     const std::string& where,
                     double tolerance = 1e-3);

// Reads the members of one object and keeps the first fault, so that the caller
// asks for it once:
//
//   Status status;
//   JsonObjectReader photo(value, "images.json", "photos[3]", &status);
//   const std::string name = photo.Text("name");
//   const int width = photo.Integer("width", 1, 65535);
//   FREEGS_RETURN_IF_ERROR(status);
//
// Several readers may share a status. After a fault each of them returns zeros
// and empty texts.
class JsonObjectReader {
 public:
  // Messages begin with "source: path.key". Both may be empty. `object` and
  // `status` must outlive the reader.
  JsonObjectReader(const nlohmann::json& object,
                   std::string source,
                   std::string path,
                   Status* status);

  bool Has(const char* key) const { return FindField(object_, key) != nullptr; }
  bool IsNull(const char* key) const;  // There, and null.

  double Number(const char* key, double min, double max);
  int Integer(const char* key, int min, int max);
  int64_t Integer64(const char* key, int64_t min, int64_t max);
  bool Bool(const char* key);
  std::string Text(const char* key);
  Eigen::Vector3d Vector3(const char* key);
  Eigen::MatrixXd Matrix(const char* key, int rows, int columns);

  // A member that is an object whose members are all texts.
  std::map<std::string, std::string> TextMap(const char* key);

  // A member that is a list of texts.
  std::vector<std::string> TextList(const char* key);

  // A member that is a list or an object. An empty one after a fault.
  const nlohmann::json& List(const char* key);
  const nlohmann::json& Object(const char* key);

  // Records a fault of the member: "source: path.key: what".
  void Fail(const std::string& key, const std::string& what);

  // How messages call the member.
  std::string Where(const std::string& key) const;

 private:
  template <typename T>
  T Keep(StatusOr<T> value, T otherwise) {
    if (!status_.ok()) return otherwise;
    if (value.ok()) return std::move(value).value();
    status_ = value.status();
    return otherwise;
  }

  const nlohmann::json& object_;
  const std::string source_;
  const std::string path_;
  Status& status_;
};

}  // namespace freegs

#endif  // FREEGS_CORE_IO_JSON_FIELDS_H_
