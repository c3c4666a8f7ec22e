// SPDX-License-Identifier: BSD-3-Clause
// Option values to and from text.

#ifndef FREEGS_PIPELINE_OPTION_VALUE_H_
#define FREEGS_PIPELINE_OPTION_VALUE_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "pipeline/option_spec.h"

namespace freegs::pipeline {

// The shortest text that reads back as the same value.
std::string OptionText(const OptionTarget& target);

// Checks that `text` is of the target's type and allowed by `spec`; with
// `store`, also sets the target. kInvalidArgument says what is wrong with the
// text, without the option's name.
Status ParseOptionText(const std::string& text,
                       const OptionSpec& spec,
                       const OptionTarget& target,
                       bool store);

// "0 .. 1", "true or false", ...: see OptionTable::Option::Allowed.
std::string AllowedText(const OptionSpec& spec,
                        const OptionTarget& target);

// The candidate closest to `name` by edit distance, if it is close enough to
// be a likely typo; otherwise empty.
std::string NearestName(const std::string& name,
                        const std::vector<std::string>& candidates);

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_OPTION_VALUE_H_
