// SPDX-License-Identifier: BSD-3-Clause

#include "stages/registry/query_options.h"

namespace freegs::stages {

void RegisterQueryOptions(semantics::TextQueryOptions& options,
                          pipeline::OptionTable& table) {
  table.AddSection("query", "Texts and examples are answered with instances.");
  table.Add("query.min_relevancy",
            &options.min_relevancy,
            {.help = "Instances less relevant to a text are not what it means; "
                     "0.5 is as relevant to any thing.",
             .min = 0,
             .max = 1,
             .affects_result = false});
  table.Add("query.background",
            &options.background,
            {.help = "Large planes (floor, walls, table tops) may answer too.",
             .affects_result = false});
}

}  // namespace freegs::stages
