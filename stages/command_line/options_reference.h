// SPDX-License-Identifier: BSD-3-Clause
// docs/options.md: all options of the stages, in tables.

#ifndef FREEGS_STAGES_COMMAND_LINE_OPTIONS_REFERENCE_H_
#define FREEGS_STAGES_COMMAND_LINE_OPTIONS_REFERENCE_H_

#include <string>

#include "pipeline/option_table.h"

namespace freegs::stages {

// The page as Markdown, one table for each section of the table.
std::string OptionsReference(const pipeline::OptionTable& table);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMAND_LINE_OPTIONS_REFERENCE_H_
