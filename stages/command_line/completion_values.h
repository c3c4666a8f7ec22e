// SPDX-License-Identifier: BSD-3-Clause
// What both shells complete for the options of a command.

#ifndef FREEGS_STAGES_COMMAND_LINE_COMPLETION_VALUES_H_
#define FREEGS_STAGES_COMMAND_LINE_COMPLETION_VALUES_H_

#include <string>
#include <vector>

#include "stages/command_line/command_words.h"

namespace freegs::stages {

// One way to write an option: "--general.preset", "--preset", "-o".
struct CompletedOption {
  std::string word;
  std::string help;                      // The first sentence of its help.
  std::vector<std::string> value_names;  // None for a switch.
  bool repeats = false;

  // What is offered for a value: these words, or what `completion` says.
  std::vector<std::string> choices;
  Completion completion = Completion::kNothing;
};

// All options that the command takes, in the order of its help, and --help.
std::vector<CompletedOption> CompletedOptions(const CommandWords& words);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMAND_LINE_COMPLETION_VALUES_H_
