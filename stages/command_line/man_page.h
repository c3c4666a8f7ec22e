// SPDX-License-Identifier: BSD-3-Clause
// The man page of the program, made of the same words as --help:
//
//   std::cout << ManPage(commands, table);    // man -l on what it prints

#ifndef FREEGS_STAGES_COMMAND_LINE_MAN_PAGE_H_
#define FREEGS_STAGES_COMMAND_LINE_MAN_PAGE_H_

#include <string>
#include <vector>

#include "pipeline/option_table.h"
#include "stages/command_line/command_words.h"

namespace freegs::stages {

// The page in roff, for section 1, with the macros of man(7). `table` holds the
// options of the stages, which the page lists once; a command that takes some
// of them only names these. It holds no date: the same program prints the same.
std::string ManPage(const std::vector<CommandWords>& commands,
                    const pipeline::OptionTable& table);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMAND_LINE_MAN_PAGE_H_
