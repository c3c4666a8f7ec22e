// SPDX-License-Identifier: BSD-3-Clause

#include "stages/registry/pipeline_options.h"

#include <utility>

#include "core/io/files.h"
#include "stages/registry/presets.h"
#include "stages/registry/query_options.h"

namespace freegs::stages {
namespace {

using pipeline::OptionSetting;
using pipeline::OptionTable;

void RegisterGeneralOptions(GeneralOptions& options, OptionTable& table) {
  table.AddSection("general", "What concerns more than one stage.");
  table.Add("general.preset",
            &options.preset,
            {.help = "Set of option values to start from: how much time to "
                     "spend on how good a result. With auto, run --within or "
                     "--at-least chooses them.",
             .choices = PresetChoices(),
             .affects_result = false});
  table.Add("general.threads",
            &options.threads,
            {.help = "Threads to work with; 0 takes one per available core. "
                     "The result does not depend on it.",
             .min = 0,
             .max = 1024,
             .affects_result = false});
  table.Add("general.seed",
            &options.seed,
            {.help = "Start of every random sequence: the same seed gives the "
                     "same result.",
             .min = 0});
  table.Add("general.checkpoint_interval",
            &options.checkpoint_interval,
            {.help = "Seconds between checkpoints of long stages.",
             .min = 0,
             .max = 86400,
             .affects_result = false});
  table.Add("general.verbose",
            &options.verbose,
            {.help = "Also log details.", .affects_result = false});
  table.AddAlias("preset", "general.preset");
  table.AddAlias("threads", "general.threads");
  table.AddAlias("seed", "general.seed");
  table.AddAlias("verbose", "general.verbose");
}

}  // namespace

OptionTable MakeOptionTable(PipelineOptions* options) {
  OptionTable table;
  RegisterGeneralOptions(options->general, table);
  RegisterIngestOptions(options->ingest, table);
  RegisterSfmOptions(options->sfm, table);
  RegisterUndistortOptions(options->undistort, table);
  RegisterReconstructOptions(options->reconstruct, table);
  RegisterBootstrapOptions(options->bootstrap, table);
  RegisterExportOptions(options->export_, table);
  RegisterQueryOptions(options->query, table);
  for (const std::string& preset : PresetNames()) {
    const auto settings = PresetSettings(preset);
    if (!settings.ok()) continue;  // A test asks for every name.
    for (const OptionSetting& setting : *settings) {
      table.NotePreset(preset, setting.name, setting.value);
    }
  }
  return table;
}

StatusOr<std::vector<OptionSetting>> ConfigSettings(
    const std::filesystem::path& workspace, const OptionTable& table) {
  const std::filesystem::path path = pipeline::ConfigPath(workspace);
  if (!IsNameTaken(path)) return std::vector<OptionSetting>();
  return table.ParseConfigFile(path);
}

Status ApplySettings(const std::filesystem::path& workspace,
                     const std::vector<OptionSetting>& command_line,
                     OptionTable& table,
                     const std::vector<OptionSetting>& chosen) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<OptionSetting> config,
                          ConfigSettings(workspace, table));
  OptionSetting preset{
      "general.preset", table.Find("general.preset")->value(), "default"};
  for (const auto* settings : {&std::as_const(config), &command_line}) {
    for (const OptionSetting& setting : *settings) {
      if (setting.name == preset.name) preset = setting;
    }
  }
  std::vector<OptionSetting> preset_settings = chosen;
  if (preset.value != kAutoPreset) {
    FREEGS_ASSIGN_OR_RETURN(preset_settings, PresetSettings(preset.value));
  } else if (chosen.empty()) {
    return InvalidArgumentError(
        "preset auto is chosen by a goal: run IMAGES WORKSPACE --within 5m, or "
        "--at-least psnr=27");
  }
  FREEGS_RETURN_IF_ERROR(table.Apply(preset_settings));
  FREEGS_RETURN_IF_ERROR(table.Apply(config));
  return table.Apply(command_line);
}

std::vector<OptionSetting> RememberedSettings(
    const std::filesystem::path& workspace,
    const pipeline::WorkspaceInfo& info,
    const OptionTable& table) {
  std::vector<OptionSetting> settings;
  for (const auto& [name, value] : info.settings) {
    const OptionTable::Option* option = table.Find(name);
    if (option == nullptr) continue;
    OptionSetting setting{
        name,
        value,
        "remembered; run WORKSPACE --forget " + name + " drops it"};
    if (option->spec.is_path) {
      setting.value = pipeline::PathInWorkspace(workspace, value);
    }
    settings.push_back(std::move(setting));
  }
  return settings;
}

Status ApplyQuerySettings(const std::filesystem::path& workspace,
                          const std::vector<OptionSetting>& command_line,
                          OptionTable& table) {
  FREEGS_ASSIGN_OR_RETURN(const pipeline::WorkspaceInfo info,
                          pipeline::ReadWorkspaceInfo(workspace));
  std::vector<OptionSetting> settings =
      RememberedSettings(workspace, info, table);
  std::erase_if(settings, [](const OptionSetting& setting) {
    return setting.name != "general.preset" &&
           !setting.name.starts_with("query.");
  });
  settings.insert(settings.end(), command_line.begin(), command_line.end());
  return ApplySettings(workspace, settings, table);
}

}  // namespace freegs::stages
