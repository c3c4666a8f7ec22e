// SPDX-License-Identifier: BSD-3-Clause
// The words that a command takes: its arguments and options, declared in one
// place. Parsing, --help (command_help.h) and the completion of shells
// (bash_completion.h, zsh_completion.h) all read this declaration, so they
// cannot differ. A command declares its words in one function:
//
//   CommandWords Describe(RenderRequest* request) {
//     CommandWords words("render", "Renders the scene from any camera.");
//     words.AddArgument(WorkspaceArgument());
//     words.AddOption("out",
//                     &request->out,
//                     {.help = "Folder for the pictures.",
//                      .value_name = "DIR"});
//     words.Require("out");
//     return words;
//   }
//
//   CommandWords RenderWords() { return KeepWords<RenderRequest>(Describe); }
//
// and the command itself reads its arguments with the same function:
//
//   RenderRequest request;
//   CommandWords words = Describe(&request);
//   FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> positional,
//                           words.ParseAndApply(arguments));

#ifndef FREEGS_STAGES_COMMAND_LINE_COMMAND_WORDS_H_
#define FREEGS_STAGES_COMMAND_LINE_COMMAND_WORDS_H_

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/status.h"
#include "pipeline/option_spec.h"
#include "pipeline/option_table.h"

namespace freegs::stages {

// A word without a name before it, such as WORKSPACE.
struct Argument {
  std::string name;
  std::string help;

  // If there are any, the only texts that are allowed.
  std::vector<std::string> choices = {};

  bool optional = false;
};

// The argument that most commands have.
Argument WorkspaceArgument();

// The absolute path of a folder that a word names. "photos/" and "photos" are
// the same path.
std::filesystem::path AbsoluteFolder(const std::string& word);

// The AbsoluteFolder of a workspace that has to be there. Returns kBadInput
// when it is not a folder.
StatusOr<std::filesystem::path> ExistingWorkspace(const std::string& word);

// An option that takes several values ("--click VIEW X Y"), or that may be
// given several times. The values of each time are added to the target.
struct ListOption {
  std::string name;
  std::vector<std::string> value_names;  // {"VIEW", "X", "Y"}
  std::string help;
  std::vector<std::vector<std::string>>* target;
  bool repeats = false;
  std::vector<std::string> offers = {};  // What a shell offers for a value.
};

// What a shell offers for a value.
enum class Completion { kNothing, kFiles, kFolders };

// What the name of a value in help tells about it: DIR and WORKSPACE are
// folders; FILE, IMAGE, IMAGES, PATH, PROGRAM and WEIGHTS are files.
Completion CompletionOf(std::string_view value_name);

// How help calls the value of an option: its value_name, else its choices
// ("color|depth"), else a word for its type.
std::string ValueName(const pipeline::OptionTable::Option& option);

class CommandWords {
 public:
  // `summary` is one sentence. With `table` the command also takes the options
  // of the table, which then has no options without a section.
  CommandWords(std::string name,
               std::string summary,
               pipeline::OptionTable table = {});

  // Arguments stand in the order in which they are added.
  void AddArgument(Argument argument);

  // Adds an option of this command alone; see OptionTable::Add.
  void AddOption(std::string name,
                 pipeline::OptionTarget target,
                 pipeline::OptionSpec spec);
  void AddListOption(ListOption option);

  // Adds --threads N; 0, one per available core.
  void AddThreads(int* threads);

  // Makes "-letter" mean "--name".
  void AddLetter(char letter, std::string name);

  // The command cannot do without this option.
  void Require(std::string name);

  // The command needs exactly one of these options.
  void RequireOneOf(std::vector<std::string> names);

  // A sentence or two that stand at the end of the help.
  void AddNote(std::string note);

  // Says in the help that all options of command `other` are taken too, instead
  // of listing them again.
  void ReferToOptionsOf(std::string other);

  // Splits arguments into settings and positional words and fills the targets
  // of list options, but not those of other options. kInvalidArgument says
  // what is wrong and how the command is called.
  StatusOr<pipeline::OptionTable::CommandLine> Parse(
      std::vector<std::string> arguments) const;

  // Does the same, also sets the targets of all options, and returns the
  // positional words.
  StatusOr<std::vector<std::string>> ParseAndApply(
      const std::vector<std::string>& arguments);

  // "render WORKSPACE --out DIR [OPTIONS]".
  std::string Usage() const;

  // "--click VIEW X Y", "--json", for an option of this command.
  std::string OptionUsage(const std::string& name) const;

  const std::string& name() const { return name_; }
  const std::string& summary() const { return summary_; }
  const std::vector<Argument>& arguments() const { return arguments_; }
  const std::vector<ListOption>& list_options() const { return list_options_; }
  const std::map<char, std::string>& letters() const { return letters_; }
  const std::vector<std::string>& notes() const { return notes_; }
  const std::string& refers_to() const { return refers_to_; }
  const pipeline::OptionTable& table() const { return table_; }
  pipeline::OptionTable& table() { return table_; }

  // Keeps an object alive as long as these words, for targets within it.
  void KeepAlive(std::shared_ptr<void> object);

 private:
  Status TakeListOption(const ListOption& option,
                        std::vector<std::string>* arguments) const;
  // Whether a word that is no option begins with a dash, without "--" before.
  Status CheckDashes(const std::vector<std::string>& arguments,
                     const std::vector<std::string>& positional) const;
  Status CheckPositional(const std::vector<std::string>& words) const;
  Status CheckRequired(const pipeline::OptionTable::CommandLine& line,
                       const std::vector<std::string>& given_lists) const;
  Status UsageError(const std::string& fault) const;

  std::string name_;
  std::string summary_;
  pipeline::OptionTable table_;
  std::vector<Argument> arguments_;
  std::vector<ListOption> list_options_;
  std::map<char, std::string> letters_;
  std::vector<std::string> required_;
  std::vector<std::string> one_of_;
  std::vector<std::string> notes_;
  std::string refers_to_;
  std::shared_ptr<void> kept_;
};

// The words that `describe` declares, for help and completion: they keep a
// request of their own, which their targets point into.
template <typename Request>
CommandWords KeepWords(CommandWords (*describe)(Request*)) {
  auto request = std::make_shared<Request>();
  CommandWords words = describe(request.get());
  words.KeepAlive(std::move(request));
  return words;
}

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMAND_LINE_COMMAND_WORDS_H_
