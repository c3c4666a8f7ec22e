// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/manual_command.h"

#include "stages/command_line/man_page.h"
#include "stages/command_line/options_reference.h"
#include "stages/registry/pipeline_options.h"

namespace freegs::stages {

CommandWords ManualWords() {
  CommandWords words("manual",
                     "Prints a page of the manual: the man page in roff, or "
                     "all options of the stages in Markdown.");
  words.AddArgument({.name = "PAGE",
                     .help = "man prints the man page; options prints tables "
                             "of all options.",
                     .choices = {"man", "options"}});
  words.AddNote(
      "To read the man page where it is not installed: freegs_pipeline manual "
      "man > freegs_pipeline.1 and man -l freegs_pipeline.1.");
  return words;
}

Status RunManualCommand(const std::vector<std::string>& arguments,
                        CommandContext& context) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> positional,
                          ManualWords().ParseAndApply(arguments));
  PipelineOptions options;
  const pipeline::OptionTable table = MakeOptionTable(&options);
  if (positional[0] == "options") {
    context.out << OptionsReference(table);
    return Status();
  }
  std::vector<CommandWords> all;
  for (const Command& command : context.commands) {
    all.push_back(command.words());
  }
  context.out << ManPage(all, table);
  return Status();
}

}  // namespace freegs::stages
