// SPDX-License-Identifier: BSD-3-Clause
// The help of the program and of its commands, for a terminal of 80 columns:
//
//   std::cout << CommandHelp(RenderWords());

#ifndef FREEGS_STAGES_COMMAND_LINE_COMMAND_HELP_H_
#define FREEGS_STAGES_COMMAND_LINE_COMMAND_HELP_H_

#include <cstddef>
#include <string>
#include <vector>

#include "pipeline/option_table.h"
#include "stages/command_line/command_words.h"

namespace freegs::stages {

// Lays out a text in lines of at most 80 columns. The first line begins with
// `first`, all others with `indent` spaces. A longer word gets its own line.
std::string WrapText(const std::string& text,
                     const std::string& first,
                     size_t indent);

// How an option is called, with its letter and its other names:
// "-o, --out FILE".
std::string OptionNames(const CommandWords& words,
                        const pipeline::OptionTable::Option& option);

// " [default 3; 1 .. 10; preset fast: 2]": what the table knows beside the
// help. Choices are named unless `shows_choices` says that the option's name
// does so.
std::string OptionFacts(const pipeline::OptionTable::Option& option,
                        bool shows_choices);

// "one, two, three".
std::string CommaList(const std::vector<std::string>& words);

// How the command is called, what it does, and each of its arguments and
// options with default, range, and values in presets.
std::string CommandHelp(const CommandWords& words);

// One entry per command, and what holds for all of them.
std::string ProgramHelp(const std::vector<CommandWords>& commands);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMAND_LINE_COMMAND_HELP_H_
