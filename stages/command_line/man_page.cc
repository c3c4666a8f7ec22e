// SPDX-License-Identifier: BSD-3-Clause

#include "stages/command_line/man_page.h"

#include <string_view>
#include <utility>

#include "core/status.h"
#include "pipeline/exit_code.h"
#include "pipeline/version.h"
#include "stages/command_line/command_help.h"
#include "stages/command_line/roff.h"

namespace freegs::stages {
namespace {

using pipeline::OptionTable;

struct Entry {
  std::string_view term;
  std::string_view text;
};

constexpr std::string_view kDescription[] = {
    "freegs_pipeline makes a 3D scene of a folder of photographs or of a film. "
    "COLMAP finds the cameras; the scene is then trained as 3D Gaussians "
    "(Gaussian Splatting); at the end the Gaussians are divided into objects, "
    "which are the same in every view and can be asked for in words, by a "
    "click, or with a picture. No graphics card is needed.",
    "One folder, the WORKSPACE, holds everything about one scene. The stages "
    "ingest, sfm, undistort, reconstruct, bootstrap and export work in it, one "
    "after the other. A run that was stopped goes on where it was when it is "
    "started again, and a run after a change of options only redoes the stages "
    "that the change concerns.",
};

constexpr Entry kFiles[] = {
    {"WORKSPACE/config.ini",
     "Options of the stages. The command init writes one in which every option "
     "is explained."},
    {"WORKSPACE/workspace.json",
     "Where the photographs are, and the options of earlier commands."},
    {"WORKSPACE/log.txt", "All messages of all runs."},
    {"WORKSPACE/STAGE/stage.json",
     "How the result of a stage was made: options, inputs, time, memory."},
    {"WORKSPACE/reconstruct/point_cloud.ply", "The scene as 3D Gaussians."},
    {"WORKSPACE/bootstrap/instances.json", "The objects and their boxes."},
    {"WORKSPACE/export/report/index.html",
     "The page about the result, for a browser."},
};

constexpr Entry kEnvironment[] = {
    {"PATH", "Where colmap and, for view --open, xdg-open are looked for."},
    {"DISPLAY", "Is not needed: COLMAP is started so that it opens no window."},
};

constexpr std::pair<StatusCode, std::string_view> kExitCodes[] = {
    {StatusCode::kOk, "Done."},
    {StatusCode::kInternal, "A fault of the program or of the system."},
    {StatusCode::kInvalidArgument, "Wrong usage."},
    {StatusCode::kBadInput, "Bad input: the message names the file."},
    {StatusCode::kUnusableResult,
     "A stage could not reach a usable result. The reason and what to try are "
     "printed and kept in stage.json."},
    {StatusCode::kMissingDependency, "A program or model file is missing."},
    {StatusCode::kInterrupted, "Interrupted; what was done so far is kept."},
};

constexpr Entry kExamples[] = {
    {"Make a scene of the photographs in the folder photos, then look at it:",
     "freegs_pipeline run photos scene\nfreegs_pipeline view scene --open"},
    {"Do it quickly, and see what is done:",
     "freegs_pipeline run photos scene --preset fast\nfreegs_pipeline status "
     "scene"},
    {"Ask where something is, with a mask of it for every photograph:",
     "freegs_pipeline query scene --text 'red apple' --out answer"},
    {"Write the scene for other viewers, and a film of it:",
     "freegs_pipeline export scene --out scene.spz\nfreegs_pipeline render "
     "scene --path orbit --video scene.mp4"},
};

std::string Section(std::string_view title) {
  return ".SH " + RoffEscaped(title, false) + "\n";
}

// A heading within a section, which is one argument of its macro.
std::string Subsection(std::string_view title) {
  std::string quoted;
  for (const char c : RoffEscaped(title, true)) {
    quoted += c == '"' ? "\\(dq" : std::string(1, c);
  }
  return ".SS \"" + quoted + "\"\n";
}

std::string Paragraph(const std::string& text) {
  return ".PP\n" + RoffText(text);
}

std::string Item(const std::string& term, const std::string& text) {
  return ".TP\n" + RoffUsage(term) + RoffText(text);
}

std::string OptionItem(const CommandWords& words,
                       const OptionTable::Option& option) {
  const std::string names = OptionNames(words, option);
  const bool shows_choices = names.find('|') != std::string::npos;
  return Item(names, option.spec.help + OptionFacts(option, shows_choices));
}

// Which options of the stages a command takes, if any.
std::string StageOptions(const CommandWords& words, size_t num_stage_options) {
  std::vector<std::string> names;
  for (const OptionTable::Option& option : words.table().options()) {
    if (!option.section().empty() && option.on_command_line) {
      names.push_back("--" + option.name);
    }
  }
  if (names.empty()) return "";
  if (names.size() == num_stage_options) {
    return Paragraph(
        "It also takes all OPTIONS OF THE STAGES, which are listed below.");
  }
  return Paragraph("Of the OPTIONS OF THE STAGES it takes " + CommaList(names) +
                   ".");
}

std::string CommandText(const CommandWords& words, size_t num_stage_options) {
  std::string text = Subsection(words.Usage()) + RoffText(words.summary());
  for (const Argument& argument : words.arguments()) {
    text += Item(argument.name,
                 argument.help +
                     (argument.choices.empty()
                          ? ""
                          : " [one of " + CommaList(argument.choices) + "]"));
  }
  for (const ListOption& option : words.list_options()) {
    text += Item(words.OptionUsage(option.name),
                 option.help +
                     (option.repeats ? " It may be given several times." : ""));
  }
  for (const OptionTable::Option& option : words.table().options()) {
    if (option.section().empty()) text += OptionItem(words, option);
  }
  text += StageOptions(words, num_stage_options);
  for (const std::string& note : words.notes()) text += Paragraph(note);
  return text;
}

std::string StagesText(const OptionTable& table) {
  const CommandWords words("", "", table);
  std::string text =
      Section("OPTIONS OF THE STAGES") +
      RoffText(
          "They are given as --SECTION.KEY VALUE on the command line, or as "
          "KEY = VALUE below [SECTION] in WORKSPACE/config.ini. The command "
          "line wins over config.ini, and config.ini over the preset.");
  for (const auto& [section, about] : table.sections()) {
    std::string items;
    for (const OptionTable::Option& option : table.options()) {
      if (option.section() == section) items += OptionItem(words, option);
    }
    if (section.empty() || items.empty()) continue;
    text += Subsection("[" + section + "]") + RoffText(about) + items;
  }
  return text;
}

std::string Synopsis(const std::vector<CommandWords>& commands) {
  std::string text = Section("SYNOPSIS");
  for (const CommandWords& words : commands) {
    text += ".SY freegs_pipeline\n" + RoffUsage(words.Usage()) + ".YS\n";
  }
  for (const char* usage : {"COMMAND --help", "help [COMMAND]", "--version"}) {
    text += ".SY freegs_pipeline\n" + RoffUsage(usage) + ".YS\n";
  }
  return text;
}

template <size_t kSize>
std::string Items(std::string_view title, const Entry (&entries)[kSize]) {
  std::string text = Section(title);
  for (const Entry& entry : entries) {
    text += Item(std::string(entry.term), std::string(entry.text));
  }
  return text;
}

std::string ExitStatus() {
  std::string text = Section("EXIT STATUS");
  for (const auto& [code, meaning] : kExitCodes) {
    text +=
        Item(std::to_string(pipeline::ExitCode(code)), std::string(meaning));
  }
  return text;
}

std::string Examples() {
  std::string text = Section("EXAMPLES");
  for (const Entry& example : kExamples) {
    text += (&example == kExamples ? "" : ".PP\n") + RoffText(example.term) +
            ".PP\n.RS 4\n.EX\n" + RoffExample(example.text) + ".EE\n.RE\n";
  }
  return text;
}

}  // namespace

std::string ManPage(const std::vector<CommandWords>& commands,
                    const OptionTable& table) {
  std::string text =
      ".\\\" Written by `freegs_pipeline manual man`.\n"
      ".TH FREEGS_PIPELINE 1 \"\" \"freegs_pipeline " +
      RoffEscaped(pipeline::kProgramVersion, true) + "\" \"User Commands\"\n" +
      Section("NAME") +
      "freegs_pipeline \\- photographs in, a 3D scene that knows its objects "
      "out\n" +
      Synopsis(commands) + Section("DESCRIPTION");
  for (const std::string_view paragraph : kDescription) {
    text += (paragraph == kDescription[0] ? "" : ".PP\n") + RoffText(paragraph);
  }
  text += Section("COMMANDS");
  for (const CommandWords& words : commands) {
    text += CommandText(words, table.options().size());
  }
  text += StagesText(table) + Items("FILES", kFiles) +
          Items("ENVIRONMENT", kEnvironment) + ExitStatus() + Examples();
  return text + Section("SEE ALSO") +
         "\\fBcolmap\\fR(1), \\fBxdg\\-open\\fR(1)\n";
}

}  // namespace freegs::stages
