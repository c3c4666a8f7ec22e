// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/evidence_model.h"

#include <string>

#include <nlohmann/json.hpp>

#include "semantics/patches/evidence_json.h"
#include "semantics/patches/logistic_model_json.h"

namespace freegs::semantics {

StatusOr<EvidenceModel> ParseEvidenceModel(std::string_view text) {
  EvidenceModel model;
  const auto read_row = [&](size_t k, const nlohmann::json& row) -> Status {
    const std::string name = kEvidenceNames[k];
    FREEGS_ASSIGN_OR_RETURN(model.mean[k], ReadModelNumber(row, name, "mean"));
    FREEGS_ASSIGN_OR_RETURN(model.deviation[k],
                            ReadModelNumber(row, name, "deviation", 1e-9));
    FREEGS_ASSIGN_OR_RETURN(model.weight[k],
                            ReadModelNumber(row, name, "weight"));
    return Status();
  };
  FREEGS_ASSIGN_OR_RETURN(model.bias,
                          ParseLogisticModel(text,
                                             {.source = "evidence",
                                              .list = "evidence",
                                              .names = {kEvidenceNames.begin(),
                                                        kEvidenceNames.end()}},
                                             read_row));
  return model;
}

StatusOr<EvidenceModel> DefaultEvidenceModel() {
  return ParseEvidenceModel(kEvidenceJson);
}

}  // namespace freegs::semantics
