// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/evidence_model.h"

#include <algorithm>
#include <string>

#include <nlohmann/json.hpp>

#include "core/io/json_fields.h"
#include "semantics/patches/evidence_json.h"

namespace freegs::semantics {
namespace {

constexpr double kMaxNumber = 1e6;

}  // namespace

StatusOr<EvidenceModel> ParseEvidenceModel(std::string_view text) {
  FREEGS_ASSIGN_OR_RETURN(const nlohmann::json document,
                          ParseJsonObject(text, "evidence"));
  const auto number = [](const nlohmann::json& object,
                         const char* key,
                         double min,
                         const std::string& where) {
    return ReadNumber(
        FindField(object, key), min, kMaxNumber, where + "." + key);
  };
  EvidenceModel model;
  FREEGS_ASSIGN_OR_RETURN(model.bias,
                          number(document, "bias", -kMaxNumber, "evidence"));
  const nlohmann::json* rows = FindField(document, "evidence");
  if (rows == nullptr || !rows->is_array() || rows->size() != kNumEvidences) {
    return BadInputError("evidence: \"evidence\" must be a list of " +
                         std::to_string(kNumEvidences) + " entries");
  }
  std::array<bool, kNumEvidences> known = {};
  for (const nlohmann::json& row : *rows) {
    FREEGS_ASSIGN_OR_RETURN(const std::string name,
                            ReadText(FindField(row, "name"), "evidence: name"));
    const auto at =
        std::find(kEvidenceNames.begin(), kEvidenceNames.end(), name);
    const auto k = static_cast<size_t>(at - kEvidenceNames.begin());
    if (at == kEvidenceNames.end() || known[k]) {
      return BadInputError("evidence: \"" + name + "\" is unknown or twice");
    }
    known[k] = true;
    FREEGS_ASSIGN_OR_RETURN(model.mean[k],
                            number(row, "mean", -kMaxNumber, name));
    FREEGS_ASSIGN_OR_RETURN(model.deviation[k],
                            number(row, "deviation", 1e-9, name));
    FREEGS_ASSIGN_OR_RETURN(model.weight[k],
                            number(row, "weight", -kMaxNumber, name));
  }
  return model;
}

StatusOr<EvidenceModel> DefaultEvidenceModel() {
  return ParseEvidenceModel(kEvidenceJson);
}

}  // namespace freegs::semantics
