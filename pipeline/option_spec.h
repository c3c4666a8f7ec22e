// SPDX-License-Identifier: BSD-3-Clause
// What one option may hold and where its value lives.

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

  // Inclusive range of a number.
  std::optional<double> min = std::nullopt;
  std::optional<double> max = std::nullopt;

  // If not empty, the only texts allowed.
  std::vector<std::string> choices = {};

  // Whether another value leads to another result, so that the stage must be
  // redone. False for the number of threads and the like.
  bool affects_result = true;

  // A file or folder: a relative path on the command line is taken from the
  // current folder, one in config.ini from config.ini's folder. An empty text
  // stays empty. Its content counts as a stage's input, its name does not, so
  // it does not affect the result by itself.
  bool is_path = false;
};

// The variable that holds an option's value.
using OptionTarget = std::variant<bool*, int*, int64_t*, double*, std::string*>;

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_OPTION_SPEC_H_
