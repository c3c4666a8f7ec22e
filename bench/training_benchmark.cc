// SPDX-License-Identifier: BSD-3-Clause
// The program freegs_training_benchmark: times training on the photographs of a
// pipeline workspace whose stage undistort is done. See kUsage.

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <boost/program_options.hpp>

#include "bench/instruction_set.h"
#include "bench/training_modes.h"
#include "core/status.h"
#include "pipeline/exit_code.h"

namespace freegs::bench {
namespace {

namespace po = boost::program_options;

constexpr char kUsage[] =
    "freegs_training_benchmark steps WORKSPACE [--max-image-size 480]\n"
    "    [--threads N] [--steps 200] [--rounds 3] [--gaussians N] [--simd "
    "NAME]\n"
    "  Time per step at the start of training; all rounds from one start.\n"
    "freegs_training_benchmark curve WORKSPACE [--preset NAME]\n"
    "    [--max-image-size N] [--threads N] [--set SECTION.KEY=VALUE ...]\n"
    "    [--every 50] [--until DB] [--simd NAME]\n"
    "  Holdout quality over time of a training as reconstruct does it; "
    "options\n"
    "  come from preset, WORKSPACE/config.ini and here. CSV.\n"
    "freegs_training_benchmark evaluate WORKSPACE PLY [--max-image-size 480]\n"
    "    [--threads N] [--background R,G,B]\n"
    "  Holdout quality of a .ply in the frame of the poses. Colours 0 .. 1.\n"
    "freegs_training_benchmark export WORKSPACE OUTDIR\n"
    "  COLMAP project of the training photos: OUTDIR/images and "
    "OUTDIR/sparse/0.\n"
    "With --simd the SIMD code runs with a lower instruction set, such as "
    "AVX2.\n";

// Reads words such as "WORKSPACE --steps 5": `places` names the words that must
// stand without an option.
Status Parse(const std::vector<std::string>& words,
             const std::vector<std::string>& places,
             const po::options_description& options,
             po::variables_map* values) {
  po::options_description all;
  all.add(options);
  po::positional_options_description positional;
  for (const std::string& place : places) {
    all.add_options()(place.c_str(), po::value<std::string>());
    positional.add(place.c_str(), 1);
  }
  const int style = po::command_line_style::unix_style &
                    ~po::command_line_style::allow_guessing;
  try {
    po::store(po::command_line_parser(words)
                  .options(all)
                  .positional(positional)
                  .style(style)
                  .run(),
              *values);
    po::notify(*values);
  } catch (const po::error& e) {
    return InvalidArgumentError(e.what());
  }
  for (const std::string& place : places) {
    if (!values->contains(place)) {
      return InvalidArgumentError(place + " is missing");
    }
  }
  return Status();
}

Status RequireAtLeast(const char* name, int64_t value, int64_t least) {
  if (value >= least) return Status();
  return InvalidArgumentError(std::string(name) + " must be at least " +
                              std::to_string(least));
}

// The option --simd.
Status UseSimd(const po::variables_map& values) {
  if (!values.contains("simd")) return Status();
  const std::string& name = values["simd"].as<std::string>();
  if (UseInstructionSet(name)) return Status();
  return InvalidArgumentError("this machine does not have --simd " + name);
}

template <typename T>
std::optional<T> Optional(const po::variables_map& values, const char* name) {
  if (!values.contains(name)) return std::nullopt;
  return values[name].as<T>();
}

Status Steps(const std::vector<std::string>& words) {
  StepsOptions options;
  po::options_description description;
  auto add = description.add_options();
  add("max-image-size", po::value(&options.max_image_size));
  add("threads", po::value(&options.threads));
  add("steps", po::value(&options.steps));
  add("rounds", po::value(&options.rounds));
  add("gaussians", po::value(&options.gaussians));
  add("simd", po::value<std::string>());
  po::variables_map values;
  FREEGS_RETURN_IF_ERROR(Parse(words, {"WORKSPACE"}, description, &values));
  FREEGS_RETURN_IF_ERROR(UseSimd(values));
  options.workspace = values["WORKSPACE"].as<std::string>();
  FREEGS_RETURN_IF_ERROR(
      RequireAtLeast("--max-image-size", options.max_image_size, 0));
  FREEGS_RETURN_IF_ERROR(RequireAtLeast("--threads", options.threads, 0));
  FREEGS_RETURN_IF_ERROR(RequireAtLeast("--steps", options.steps, 1));
  FREEGS_RETURN_IF_ERROR(RequireAtLeast("--rounds", options.rounds, 1));
  FREEGS_RETURN_IF_ERROR(RequireAtLeast("--gaussians", options.gaussians, 0));
  return RunSteps(options);
}

Status Curve(const std::vector<std::string>& words) {
  CurveOptions options;
  po::options_description description;
  auto add = description.add_options();
  add("preset", po::value<std::string>());
  add("max-image-size", po::value<int>());
  add("threads", po::value<int>());
  add("set", po::value(&options.settings)->composing());
  add("every", po::value(&options.every));
  add("until", po::value<double>());
  add("simd", po::value<std::string>());
  po::variables_map values;
  FREEGS_RETURN_IF_ERROR(Parse(words, {"WORKSPACE"}, description, &values));
  FREEGS_RETURN_IF_ERROR(UseSimd(values));
  options.workspace = values["WORKSPACE"].as<std::string>();
  options.preset = Optional<std::string>(values, "preset");
  options.max_image_size = Optional<int>(values, "max-image-size");
  options.threads = Optional<int>(values, "threads");
  options.until = Optional<double>(values, "until");
  FREEGS_RETURN_IF_ERROR(RequireAtLeast("--every", options.every, 1));
  return RunCurve(options);
}

// "0.5,1,0".
StatusOr<std::array<float, 3>> ParseColor(const std::string& text) {
  std::array<float, 3> color = {};
  std::istringstream stream(text);
  bool good = true;
  for (size_t k = 0; k < color.size() && good; ++k) {
    good = (k == 0 || stream.get() == ',') && stream >> color[k] &&
           color[k] >= 0 && color[k] <= 1;
  }
  if (good && stream.peek() == std::char_traits<char>::eof()) return color;
  return InvalidArgumentError("--background " + text +
                              ": not three numbers from 0 to 1 as in 1,1,1");
}

Status Evaluate(const std::vector<std::string>& words) {
  EvaluateOptions options;
  std::string background = "0,0,0";
  po::options_description description;
  auto add = description.add_options();
  add("max-image-size", po::value(&options.max_image_size));
  add("threads", po::value(&options.threads));
  add("background", po::value(&background));
  po::variables_map values;
  FREEGS_RETURN_IF_ERROR(
      Parse(words, {"WORKSPACE", "PLY"}, description, &values));
  options.workspace = values["WORKSPACE"].as<std::string>();
  options.ply = values["PLY"].as<std::string>();
  FREEGS_RETURN_IF_ERROR(
      RequireAtLeast("--max-image-size", options.max_image_size, 0));
  FREEGS_RETURN_IF_ERROR(RequireAtLeast("--threads", options.threads, 0));
  FREEGS_ASSIGN_OR_RETURN(options.background, ParseColor(background));
  return RunEvaluate(options);
}

Status Export(const std::vector<std::string>& words) {
  po::variables_map values;
  FREEGS_RETURN_IF_ERROR(Parse(
      words, {"WORKSPACE", "OUTDIR"}, po::options_description(), &values));
  return RunExport({values["WORKSPACE"].as<std::string>(),
                    values["OUTDIR"].as<std::string>()});
}

Status Run(const std::vector<std::string>& words) {
  if (words.empty()) return InvalidArgumentError("no mode given; see --help");
  const std::vector<std::string> rest(words.begin() + 1, words.end());
  if (words[0] == "steps") return Steps(rest);
  if (words[0] == "curve") return Curve(rest);
  if (words[0] == "evaluate") return Evaluate(rest);
  if (words[0] == "export") return Export(rest);
  return InvalidArgumentError("unknown mode " + words[0] +
                              "; there are steps, curve, evaluate, export");
}

}  // namespace
}  // namespace freegs::bench

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (std::find(words.begin(), words.end(), "--help") != words.end()) {
    std::cout << freegs::bench::kUsage;
    return 0;
  }
  try {
    const freegs::Status status = freegs::bench::Run(words);
    if (!status.ok()) {
      std::cerr << "freegs_training_benchmark: " << status.message() << "\n";
    }
    return freegs::pipeline::ExitCode(status.code());
  } catch (const std::exception& e) {
    std::cerr << "freegs_training_benchmark: internal error: " << e.what()
              << "\n";
    return 1;
  }
}
