// SPDX-License-Identifier: BSD-3-Clause
// The options of earlier command lines, which workspace.json keeps.
//
// `run IMAGES WORKSPACE` begins with its own command line alone, so that the
// same command always means the same. What builds on an earlier command goes on
// with its options: `run WORKSPACE`, a run with --forget, `stage` and `status`.

#ifndef FREEGS_STAGES_COMMAND_LINE_REMEMBERED_OPTIONS_H_
#define FREEGS_STAGES_COMMAND_LINE_REMEMBERED_OPTIONS_H_

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/status.h"
#include "pipeline/option_table.h"
#include "pipeline/workspace.h"
#include "stages/command_line/command_words.h"

namespace freegs::stages {

// Adds "--forget KEY", which may be given several times, to a command that
// takes the options of its table.
void AddForgetOption(std::vector<std::vector<std::string>>* target,
                     CommandWords* words);

// Drops the options that were given to --forget: names or aliases of `table`,
// or "all". kInvalidArgument for one that is not remembered lists those that
// are.
Status ForgetOptions(const std::vector<std::vector<std::string>>& given,
                     const pipeline::OptionTable& table,
                     pipeline::WorkspaceInfo* info);

// Remembers the settings of a command line. Paths are stored as DisplayPath
// writes them, but that of a program as it is, which is absolute.
void RememberOptions(const std::filesystem::path& workspace,
                     const pipeline::OptionTable& table,
                     const std::vector<pipeline::OptionSetting>& settings,
                     pipeline::WorkspaceInfo* info);

// Lists the options in `before` that the command line does not set, as
// "sfm.camera single, general.seed 3". Empty if there are none.
std::string OtherOptionsText(
    const std::map<std::string, std::string>& before,
    const std::vector<pipeline::OptionSetting>& command_line);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMAND_LINE_REMEMBERED_OPTIONS_H_
