// SPDX-License-Identifier: BSD-3-Clause

#include "stages/command_line/completion_values.h"

#include <utility>
#include <variant>

namespace freegs::stages {
namespace {

using pipeline::OptionTable;

std::string FirstSentence(const std::string& text) {
  const size_t end = text.find(". ");
  std::string sentence = text.substr(0, end);
  if (sentence.ends_with('.')) sentence.pop_back();
  return sentence;
}

CompletedOption Complete(std::string word, const OptionTable::Option& option) {
  CompletedOption completed;
  completed.word = std::move(word);
  completed.help = FirstSentence(option.spec.help);
  completed.value_names = {ValueName(option)};
  completed.choices = option.spec.choices;
  if (std::holds_alternative<bool*>(option.target)) {
    completed.choices = {"true", "false"};
  }
  completed.completion = CompletionOf(completed.value_names[0]);
  return completed;
}

}  // namespace

std::vector<CompletedOption> CompletedOptions(const CommandWords& words) {
  std::vector<CompletedOption> all;
  for (const ListOption& option : words.list_options()) {
    all.push_back({.word = "--" + option.name,
                   .help = FirstSentence(option.help),
                   .value_names = option.value_names,
                   .repeats = option.repeats,
                   .choices = option.offers,
                   .completion = Completion::kNothing});
  }
  for (const OptionTable::Option& option : words.table().options()) {
    if (!option.on_command_line) continue;
    all.push_back(Complete("--" + option.name, option));
    if (option.is_switch()) all.back().value_names.clear();
    for (const auto& [alias, name] : words.table().aliases()) {
      if (name != option.name) continue;
      all.push_back(Complete("--" + alias, option));
      // The table takes the alias of a bool for a switch.
      if (std::holds_alternative<bool*>(option.target)) {
        all.back().value_names.clear();
      }
    }
    for (const auto& [letter, name] : words.letters()) {
      if (name != option.name) continue;
      all.push_back(Complete(std::string("-") + letter, option));
    }
  }
  all.push_back({.word = "--help",
                 .help = "What the command takes",
                 .value_names = {},
                 .repeats = false,
                 .choices = {},
                 .completion = Completion::kNothing});
  return all;
}

}  // namespace freegs::stages
