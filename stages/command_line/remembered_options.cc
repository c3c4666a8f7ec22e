// SPDX-License-Identifier: BSD-3-Clause

#include "stages/command_line/remembered_options.h"

#include <algorithm>
#include <utility>

namespace freegs::stages {

using pipeline::OptionSetting;
using pipeline::OptionTable;

namespace {

// Stands for all remembered options.
constexpr char kForgetAll[] = "all";

}  // namespace

void AddForgetOption(std::vector<std::vector<std::string>>* target,
                     CommandWords* words) {
  std::vector<std::string> names = {kForgetAll};
  for (const OptionTable::Option& option : words->table().options()) {
    if (!option.section().empty()) names.push_back(option.name);
  }
  words->AddListOption(
      {.name = "forget",
       .value_names = {"KEY"},
       .help = "Drop this remembered option (SECTION.KEY), or all, and use the "
               "others; freegs_pipeline status lists them.",
       .target = target,
       .repeats = true,
       .offers = std::move(names)});
}

Status ForgetOptions(const std::vector<std::vector<std::string>>& given,
                     const OptionTable& table,
                     pipeline::WorkspaceInfo* info) {
  const std::map<std::string, std::string> before = info->settings;
  for (const std::vector<std::string>& values : given) {
    const std::string& name = values.front();
    if (name == kForgetAll) {
      info->settings.clear();
      continue;
    }
    const auto alias = table.aliases().find(name);
    const std::string& full =
        alias == table.aliases().end() ? name : alias->second;
    if (!before.contains(full)) {
      return InvalidArgumentError(
          "--forget " + name + ": the workspace remembers " +
          (before.empty() ? "no options"
                          : "only " + OtherOptionsText(before, {})));
    }
    info->settings.erase(full);
  }
  return Status();
}

void RememberOptions(const std::filesystem::path& workspace,
                     const OptionTable& table,
                     const std::vector<OptionSetting>& settings,
                     pipeline::WorkspaceInfo* info) {
  for (const OptionSetting& setting : settings) {
    const OptionTable::Option* option = table.Find(setting.name);
    if (option->section().empty()) continue;
    std::string& stored = info->settings[setting.name];
    stored = setting.value;
    if (option->spec.is_path && !stored.empty()) {
      stored = pipeline::DisplayPath(workspace, stored);
    }
  }
}

std::string OtherOptionsText(const std::map<std::string, std::string>& before,
                             const std::vector<OptionSetting>& command_line) {
  std::string text;
  for (const auto& [name, value] : before) {
    const bool given =
        std::any_of(command_line.begin(),
                    command_line.end(),
                    [&name = name](const OptionSetting& setting) {
                      return setting.name == name;
                    });
    if (given) continue;
    text += (text.empty() ? "" : ", ") + name + " " +
            (value.empty() ? "''" : value);
  }
  return text;
}

}  // namespace freegs::stages
