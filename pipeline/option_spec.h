// SPDX-License-Identifier: BSD-3-Clause
// The meaning of one option, the values it may have, and where its value is
// stored.

#ifndef FREEGS_PIPELINE_OPTION_SPEC_H_
#define FREEGS_PIPELINE_OPTION_SPEC_H_

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace freegs::pipeline {

// What an option means and which values it may take.
struct OptionSpec {
  std::string help = {};  // One or two sentences, with the unit.

  // How help calls the value: "N", "WORDS". Where it is empty, help takes the
  // type. A shell completes the names of files or folders where the value is
  // called FILE, IMAGE, PATH or DIR (stages/command_line/command_words.h).
  std::string value_name = {};

  // The least and the largest value of a number.
  std::optional<double> min = std::nullopt;
  std::optional<double> max = std::nullopt;

  // If there are any, the only texts that are allowed.
  std::vector<std::string> choices = {};

  // For what the fields above cannot say: returns whether a text of the right
  // type is allowed. `allowed` then tells in words what is.
  bool (*accepts)(const std::string& text) = nullptr;
  std::string allowed = {};

  // Whether help tells the default. False where an option that is not given
  // means something that no value does.
  bool shows_default = true;

  // Whether another value leads to another result, so that the stage must run
  // again. False for the number of threads and the like.
  bool affects_result = true;

  // Whether the value is the path of a file or folder. A relative path on the
  // command line starts at the current folder, one in config.ini at the folder
  // of config.ini. An empty text stays empty. The content of the file counts as
  // an input of the stage, and so its name does not affect the result.
  bool is_path = false;

  // Whether the value is a program: a name that is looked for in PATH or, if
  // there is a '/' in it, a path that starts where that of is_path does.
  bool is_program = false;

  // Whether this value of the option is a path.
  bool HasPath(const std::string& value) const {
    return is_path || (is_program && value.find('/') != std::string::npos);
  }
};

// Points to the variable that holds the value of an option.
using OptionTarget = std::variant<bool*, int*, int64_t*, double*, std::string*>;

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_OPTION_SPEC_H_
