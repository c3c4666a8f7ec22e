// SPDX-License-Identifier: BSD-3-Clause

#include "stages/command_line/command_words.h"

#include <algorithm>
#include <cstdint>
#include <set>
#include <system_error>
#include <variant>

#include "pipeline/option_value.h"
#include "pipeline/workspace.h"

namespace freegs::stages {
namespace {

using pipeline::OptionTable;

// Longer lists of choices do not fit on the line of the option's name.
constexpr size_t kMaxChoicesLength = 44;

std::string JoinWith(const std::vector<std::string>& words,
                     const std::string& between) {
  std::string text;
  for (const std::string& word : words) {
    text += (text.empty() ? "" : between) + word;
  }
  return text;
}

bool Contains(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

}  // namespace

std::filesystem::path AbsoluteFolder(const std::string& word) {
  std::filesystem::path absolute = pipeline::AbsolutePath(word);
  if (!absolute.has_filename()) absolute = absolute.parent_path();
  return absolute;
}

StatusOr<std::filesystem::path> ExistingWorkspace(const std::string& word) {
  std::filesystem::path workspace = AbsoluteFolder(word);
  std::error_code error;
  if (std::filesystem::is_directory(workspace, error)) return workspace;
  return BadInputError(workspace.string() + ": no such workspace");
}

Argument WorkspaceArgument() {
  return {.name = "WORKSPACE", .help = "The folder of the scene."};
}

Completion CompletionOf(std::string_view value_name) {
  for (const char* folder : {"DIR", "WORKSPACE"}) {
    if (value_name == folder) return Completion::kFolders;
  }
  for (const char* file :
       {"FILE", "IMAGE", "IMAGES", "PATH", "PROGRAM", "WEIGHTS"}) {
    if (value_name == file) return Completion::kFiles;
  }
  return Completion::kNothing;
}

std::string ValueName(const OptionTable::Option& option) {
  const pipeline::OptionSpec& spec = option.spec;
  if (!spec.value_name.empty()) return spec.value_name;
  if (!spec.choices.empty()) {
    std::string choices = JoinWith(spec.choices, "|");
    return choices.size() > kMaxChoicesLength ? "NAME" : choices;
  }
  if (spec.is_path) return "PATH";
  if (std::holds_alternative<bool*>(option.target)) return "true|false";
  if (std::holds_alternative<std::string*>(option.target)) return "TEXT";
  return std::holds_alternative<double*>(option.target) ? "X" : "N";
}

CommandWords::CommandWords(std::string name,
                           std::string summary,
                           OptionTable table)
    : name_(std::move(name)),
      summary_(std::move(summary)),
      table_(std::move(table)) {}

void CommandWords::AddArgument(Argument argument) {
  arguments_.push_back(std::move(argument));
}

void CommandWords::AddOption(std::string name,
                             pipeline::OptionTarget target,
                             pipeline::OptionSpec spec) {
  table_.Add(std::move(name), target, std::move(spec));
}

void CommandWords::AddListOption(ListOption option) {
  list_options_.push_back(std::move(option));
}

void CommandWords::AddLetter(char letter, std::string name) {
  letters_[letter] = std::move(name);
}

void CommandWords::Require(std::string name) {
  required_.push_back(std::move(name));
}

void CommandWords::AddThreads(int* threads) {
  AddOption("threads",
            threads,
            {.help = "Threads to work with; 0 takes one per available core.",
             .min = 0,
             .max = 1024});
}

void CommandWords::RequireOneOf(std::vector<std::string> names) {
  one_of_ = std::move(names);
}

void CommandWords::AddNote(std::string note) {
  notes_.push_back(std::move(note));
}

void CommandWords::ReferToOptionsOf(std::string other) {
  refers_to_ = std::move(other);
}

void CommandWords::KeepAlive(std::shared_ptr<void> object) {
  kept_ = std::move(object);
}

std::string CommandWords::OptionUsage(const std::string& name) const {
  for (const ListOption& option : list_options_) {
    if (option.name == name) {
      return "--" + name + " " + JoinWith(option.value_names, " ");
    }
  }
  const OptionTable::Option* option = table_.Find(name);
  return "--" + name +
         (option == nullptr || option->is_switch() ? ""
                                                   : " " + ValueName(*option));
}

std::string CommandWords::Usage() const {
  std::string text = name_;
  for (const Argument& argument : arguments_) {
    text +=
        argument.optional ? " [" + argument.name + "]" : " " + argument.name;
  }
  for (const std::string& name : required_) text += " " + OptionUsage(name);
  std::string choice;
  for (const std::string& name : one_of_) {
    choice += (choice.empty() ? " (" : " | ") + OptionUsage(name);
  }
  text += choice + (choice.empty() ? "" : ")");
  const size_t others =
      table_.options().size() + list_options_.size() - required_.size();
  return text + (others > one_of_.size() ? " [OPTIONS]" : "");
}

Status CommandWords::UsageError(const std::string& fault) const {
  return InvalidArgumentError(fault + "; usage: " + Usage());
}

// Takes the option and its values out of the arguments, as often as it is
// there. The option table knows only options of one value.
Status CommandWords::TakeListOption(const ListOption& option,
                                    std::vector<std::string>* arguments) const {
  const std::string word = "--" + option.name;
  const size_t num_values = option.value_names.size();
  size_t times = 0;
  for (size_t at = 0; at < arguments->size() && (*arguments)[at] != "--";) {
    std::string& argument = (*arguments)[at];
    // "--forget=KEY" is "--forget KEY".
    if (num_values == 1 && argument.starts_with(word + "=")) {
      const std::string value = argument.substr(word.size() + 1);
      argument = word;
      arguments->insert(arguments->begin() + static_cast<int64_t>(at) + 1,
                        value);
    }
    if ((*arguments)[at] != word) {
      ++at;
      continue;
    }
    if (++times > 1 && !option.repeats) {
      return InvalidArgumentError(word + " is given twice");
    }
    const auto first = arguments->begin() + static_cast<int64_t>(at) + 1;
    if (static_cast<size_t>(arguments->end() - first) < num_values ||
        std::any_of(first,
                    first + static_cast<int64_t>(num_values),
                    [](const std::string& value) {
                      return value.empty() || value.starts_with("--");
                    })) {
      return UsageError(word + " needs " + JoinWith(option.value_names, " "));
    }
    const auto last = first + static_cast<int64_t>(num_values);
    option.target->emplace_back(first, last);
    arguments->erase(first - 1, last);
  }
  return Status();
}

Status CommandWords::CheckPositional(
    const std::vector<std::string>& words) const {
  std::vector<std::string> names;
  size_t least = 0;
  for (const Argument& argument : arguments_) {
    names.push_back(argument.name);
    if (!argument.optional) ++least;
  }
  if (words.size() < least || words.size() > arguments_.size()) {
    return UsageError(
        name_ + " takes " +
        (names.empty() ? "no argument but options" : JoinWith(names, " and ")) +
        ", and " + std::to_string(words.size()) +
        (words.size() == 1 ? " word was" : " words were") + " given");
  }
  // Which words are meant is certain only if there are as many as arguments.
  for (size_t k = 0; words.size() == names.size() && k < words.size(); ++k) {
    const std::vector<std::string>& choices = arguments_[k].choices;
    if (choices.empty() || Contains(choices, words[k])) continue;
    const std::string nearest = pipeline::NearestName(words[k], choices);
    return UsageError(
        "unknown " + names[k] + " " + words[k] +
        (nearest.empty() ? "" : ", did you mean " + nearest + "?") +
        "; there are " + JoinWith(choices, ", "));
  }
  return Status();
}

Status CommandWords::CheckRequired(
    const OptionTable::CommandLine& line,
    const std::vector<std::string>& given_lists) const {
  std::set<std::string> given(given_lists.begin(), given_lists.end());
  for (const pipeline::OptionSetting& setting : line.settings) {
    given.insert(setting.name);
  }
  for (const std::string& name : required_) {
    if (given.contains(name)) continue;
    return UsageError(name_ + " needs " + OptionUsage(name));
  }
  const auto chosen = std::count_if(
      one_of_.begin(), one_of_.end(), [&given](const std::string& name) {
        return given.contains(name);
      });
  if (one_of_.empty() || chosen == 1) return Status();
  return UsageError(name_ + " needs exactly one of --" +
                    JoinWith(one_of_, ", --"));
}

Status CommandWords::CheckDashes(
    const std::vector<std::string>& arguments,
    const std::vector<std::string>& positional) const {
  const auto end = std::find(arguments.begin(), arguments.end(), "--");
  for (const std::string& word : positional) {
    const bool dashed = word.size() > 1 && word[0] == '-';
    if (!dashed || std::find(arguments.begin(), end, word) == end) continue;
    return UsageError(word +
                      ": options begin with two dashes; a file or folder of "
                      "this name is ./" +
                      word);
  }
  return Status();
}

StatusOr<OptionTable::CommandLine> CommandWords::Parse(
    std::vector<std::string> arguments) const {
  for (std::string& argument : arguments) {
    if (argument == "--") break;
    const bool letter = argument.size() == 2 && argument[0] == '-';
    const auto found = letters_.find(letter ? argument[1] : '-');
    if (found != letters_.end()) argument = "--" + found->second;
  }
  std::vector<std::string> given_lists;
  for (const ListOption& option : list_options_) {
    const size_t before = option.target->size();
    FREEGS_RETURN_IF_ERROR(TakeListOption(option, &arguments));
    if (option.target->size() > before) given_lists.push_back(option.name);
  }
  FREEGS_ASSIGN_OR_RETURN(OptionTable::CommandLine line,
                          table_.ParseCommandLine(arguments));
  FREEGS_RETURN_IF_ERROR(CheckDashes(arguments, line.positional));
  FREEGS_RETURN_IF_ERROR(CheckPositional(line.positional));
  FREEGS_RETURN_IF_ERROR(CheckRequired(line, given_lists));
  return line;
}

StatusOr<std::vector<std::string>> CommandWords::ParseAndApply(
    const std::vector<std::string>& arguments) {
  FREEGS_ASSIGN_OR_RETURN(OptionTable::CommandLine line, Parse(arguments));
  FREEGS_RETURN_IF_ERROR(table_.Apply(line.settings));
  return std::move(line.positional);
}

}  // namespace freegs::stages
