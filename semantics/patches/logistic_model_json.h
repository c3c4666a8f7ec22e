// SPDX-License-Identifier: BSD-3-Clause
// Reads a logistic regression over named numbers, of whatever form, from JSON:
//
//   {"bias": -1, "numbers": [{"name": "size", "weight": 0.1, ...}, ...]}

#ifndef FREEGS_SEMANTICS_PATCHES_LOGISTIC_MODEL_JSON_H_
#define FREEGS_SEMANTICS_PATCHES_LOGISTIC_MODEL_JSON_H_

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/function_ref.h"
#include "core/status.h"

namespace freegs::semantics {

// No number of a model has a larger magnitude.
inline constexpr double kMaxModelNumber = 1e6;

struct LogisticModelFormat {
  std::string source = {};              // What messages call the text.
  const char* list = "";                // The key of the list.
  std::vector<std::string> names = {};  // The list has a row for each of them.
};

// Returns the bias. Calls read_row(k, row) for the row of names[k], which reads
// the other members of the row; rows may be in any order. The error is
// kBadInput, or the first one that read_row returns.
StatusOr<double> ParseLogisticModel(
    std::string_view text,
    const LogisticModelFormat& format,
    FunctionRef<Status(size_t k, const nlohmann::json& row)> read_row);

// Reads a member of a row: a number from `min` to kMaxModelNumber. kBadInput
// begins with "name.key".
StatusOr<double> ReadModelNumber(const nlohmann::json& row,
                                 const std::string& name,
                                 const char* key,
                                 double min = -kMaxModelNumber);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_LOGISTIC_MODEL_JSON_H_
