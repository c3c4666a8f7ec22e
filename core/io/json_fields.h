// SPDX-License-Identifier: BSD-3-Clause
// Reads JSON that somebody else wrote: every fault becomes kBadInput with the
// file, the entry and what was expected there.

#ifndef FREEGS_CORE_IO_JSON_FIELDS_H_
#define FREEGS_CORE_IO_JSON_FIELDS_H_

#include <string>
#include <string_view>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "core/status.h"

namespace freegs {

// Deeper nesting of objects and lists is refused: no file of ours needs it, and
// code that walks the document may recurse.
constexpr int kMaxJsonDepth = 64;

// Parses a document. `source` names it in messages, usually by its path.
StatusOr<nlohmann::json> ParseJson(std::string_view text,
                                   const std::string& source);

// The same for a document whose top level must be an object.
StatusOr<nlohmann::json> ParseJsonObject(std::string_view text,
                                         const std::string& source);

// The member `key`; null when there is none or when `object` is no object.
const nlohmann::json* FindField(const nlohmann::json& object, const char* key);

// A finite number. `value` may be null, which is a fault like any other; the
// message begins with `where`, such as "cameras.json: intrinsics.fx".
StatusOr<double> ReadNumber(const nlohmann::json* value,
                            const std::string& where);

// A whole number in [min, max], written as 3 or as 3.0.
StatusOr<int> ReadInteger(const nlohmann::json* value,
                          int min,
                          int max,
                          const std::string& where);

StatusOr<std::string> ReadText(const nlohmann::json* value,
                               const std::string& where);

// A list of three finite numbers.
StatusOr<Eigen::Vector3d> ReadVector3(const nlohmann::json* value,
                                      const std::string& where);

// A list of `rows` lists of `columns` finite numbers.
StatusOr<Eigen::MatrixXd> ReadMatrix(const nlohmann::json* value,
                                     int rows,
                                     int columns,
                                     const std::string& where);

// kBadInput unless the matrix is orthonormal with determinant 1, to within
// 1e-3 in every entry of R R^T.
Status CheckRotation(const Eigen::Matrix3d& rotation, const std::string& where);

}  // namespace freegs

#endif  // FREEGS_CORE_IO_JSON_FIELDS_H_
