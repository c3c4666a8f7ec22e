// SPDX-License-Identifier: BSD-3-Clause
// Converts values of options to and from text.

#ifndef FREEGS_PIPELINE_OPTION_VALUE_H_
#define FREEGS_PIPELINE_OPTION_VALUE_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "pipeline/option_spec.h"

namespace freegs::pipeline {

// Returns the shortest text that reads back as the same value.
std::string OptionText(const OptionTarget& target);

// Checks that `text` has the type of the target and is allowed by `spec`. With
// `store` it also sets the target. The message of kInvalidArgument says what is
// wrong with the text, without the name of the option.
Status ParseOptionText(const std::string& text,
                       const OptionSpec& spec,
                       const OptionTarget& target,
                       bool store);

// What `spec` allows, as text: see OptionTable::Option::Allowed.
std::string AllowedText(const OptionSpec& spec, const OptionTarget& target);

// Returns the candidate that is closest to `name` by edit distance, if it is so
// close that `name` is probably a typing error. Otherwise the text is empty.
std::string NearestName(const std::string& name,
                        const std::vector<std::string>& candidates);

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_OPTION_VALUE_H_
