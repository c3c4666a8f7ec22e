// SPDX-License-Identifier: BSD-3-Clause
// Section [query] of config.ini: how words are answered, by the commands
// `query` and `eval`.

#ifndef FREEGS_STAGES_REGISTRY_QUERY_OPTIONS_H_
#define FREEGS_STAGES_REGISTRY_QUERY_OPTIONS_H_

#include "pipeline/option_table.h"
#include "semantics/queries/text_query.h"

namespace freegs::stages {

// Adds query.min_relevancy and query.background to the table, which keeps
// pointers to `options`.
void RegisterQueryOptions(semantics::TextQueryOptions& options,
                          pipeline::OptionTable& table);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_REGISTRY_QUERY_OPTIONS_H_
