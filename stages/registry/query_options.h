// SPDX-License-Identifier: BSD-3-Clause
// [query] of config.ini: how text is answered, by `query` and wherever else
// texts are asked.

#ifndef FREEGS_STAGES_REGISTRY_QUERY_OPTIONS_H_
#define FREEGS_STAGES_REGISTRY_QUERY_OPTIONS_H_

#include "pipeline/option_table.h"
#include "semantics/queries/text_query.h"

namespace freegs::stages {

// query.min_relevancy and query.background.
void RegisterQueryOptions(semantics::TextQueryOptions& options,
                          pipeline::OptionTable& table);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_REGISTRY_QUERY_OPTIONS_H_
