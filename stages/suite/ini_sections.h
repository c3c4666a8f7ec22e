// SPDX-License-Identifier: BSD-3-Clause
// Reads an INI file whose sections are made up by its author, such as
// "[scene fox]". (A config.ini, whose sections are known, is read by
// pipeline/option_table.h.)

#ifndef FREEGS_STAGES_SUITE_INI_SECTIONS_H_
#define FREEGS_STAGES_SUITE_INI_SECTIONS_H_

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/status.h"

namespace freegs::stages {

// "[KIND NAME]" and the lines KEY = VALUE below it, in their order.
struct IniSection {
  std::string kind;
  std::string name;  // Empty in "[KIND]".
  std::vector<std::pair<std::string, std::string>> entries;

  // The value of a key; null when it is not there.
  const std::string* Find(const std::string& key) const;

  // "[scene fox]", for messages.
  std::string Title() const;
};

// What follows a # is a comment. kInvalidArgument, which names `source` and the
// line, for anything that is not of this form: text outside of a section, a
// section or a key that is there twice, a section without a key, control
// characters, more than 1 MiB.
StatusOr<std::vector<IniSection>> ParseIniSections(const std::string& text,
                                                   const std::string& source);

// Puts the value of a variable where the text says ${NAME}. `look_up` returns
// nothing for a variable that it does not know; the message of kInvalidArgument
// then names it. What a variable holds is not looked at again.
using LookUpFn =
    std::function<std::optional<std::string>(const std::string& name)>;
StatusOr<std::string> ExpandVariables(const std::string& text,
                                      const LookUpFn& look_up);

// Splits a value at its spaces; "words in quotes" stay together.
StatusOr<std::vector<std::string>> SplitWords(const std::string& text);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SUITE_INI_SECTIONS_H_
