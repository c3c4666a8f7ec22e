// SPDX-License-Identifier: BSD-3-Clause
// Text as the source of a man page, which roff reads: backslashes, hyphens and
// points at the start of a line mean something to it.
//
//   page += ".TP\n" + RoffUsage("--out DIR") + RoffText("Folder. See man(7).");

#ifndef FREEGS_STAGES_COMMAND_LINE_ROFF_H_
#define FREEGS_STAGES_COMMAND_LINE_ROFF_H_

#include <string>
#include <string_view>

namespace freegs::stages {

// One word or line that reads as `text` does. `literal` makes a hyphen-minus of
// every "-", as in names that somebody copies into a shell.
std::string RoffEscaped(std::string_view text, bool literal);

// Lines of at most 80 columns for a text in plain words. Hyphens within words
// of letters alone stay hyphens; those in names and options do not.
std::string RoffText(std::string_view text);

// One line for how something is called: "--click VIEW X Y [OPTIONS]". What is
// written as it stands is bold; words in capital letters stand for something
// else and are slanted.
std::string RoffUsage(std::string_view usage);

// Lines that stay as they are: examples.
std::string RoffExample(std::string_view lines);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMAND_LINE_ROFF_H_
