// SPDX-License-Identifier: BSD-3-Clause
// What --version prints.

#ifndef FREEGS_STAGES_COMMAND_LINE_VERSION_TEXT_H_
#define FREEGS_STAGES_COMMAND_LINE_VERSION_TEXT_H_

#include <string>
#include <string_view>

namespace freegs::stages {

// The instruction sets that the program can use on this machine, the best one
// first: "AVX2, SSE4, SSE2 (the first is used)".
std::string InstructionSets();

// Lines for the version, with the commit it was built from, the instruction
// sets and the licence.
std::string VersionText(std::string_view commit);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMAND_LINE_VERSION_TEXT_H_
