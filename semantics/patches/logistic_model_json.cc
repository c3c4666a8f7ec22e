// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/logistic_model_json.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "core/io/json_fields.h"

namespace freegs::semantics {

StatusOr<double> ReadModelNumber(const nlohmann::json& row,
                                 const std::string& name,
                                 const char* key,
                                 double min) {
  return ReadNumber(
      FindField(row, key), min, kMaxModelNumber, name + "." + key);
}

StatusOr<double> ParseLogisticModel(
    std::string_view text,
    const LogisticModelFormat& format,
    FunctionRef<Status(size_t k, const nlohmann::json& row)> read_row) {
  const auto& [source, list, names] = format;
  FREEGS_ASSIGN_OR_RETURN(const nlohmann::json document,
                          ParseJsonObject(text, source));
  FREEGS_ASSIGN_OR_RETURN(const double bias,
                          ReadModelNumber(document, source, "bias"));
  const nlohmann::json* rows = FindField(document, list);
  if (rows == nullptr || !rows->is_array() || rows->size() != names.size()) {
    return BadInputError(source + ": \"" + list + "\" must be a list of " +
                         std::to_string(names.size()) + " entries");
  }
  std::vector<bool> known(names.size(), false);
  for (const nlohmann::json& row : *rows) {
    FREEGS_ASSIGN_OR_RETURN(
        const std::string name,
        ReadText(FindField(row, "name"), source + ": name"));
    const auto at = std::find(names.begin(), names.end(), name);
    const auto k = static_cast<size_t>(at - names.begin());
    if (at == names.end() || known[k]) {
      return BadInputError(source + ": \"" + name + "\" is unknown or twice");
    }
    known[k] = true;
    FREEGS_RETURN_IF_ERROR(read_row(k, row));
  }
  return bias;
}

}  // namespace freegs::semantics
