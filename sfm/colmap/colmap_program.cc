// SPDX-License-Identifier: BSD-3-Clause
// Asks the installed `colmap` program what it can do.

#include "sfm/colmap/colmap_program.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace freegs::sfm {
namespace {

constexpr char kAdvice[] =
    "install COLMAP 3.8 or newer (Debian: apt install colmap), or name the "
    "program with --sfm.colmap";

// A program that takes longer to say what it can do is stuck.
constexpr double kHelpSeconds = 120;

bool IsOptionCharacter(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' ||
         c == '.' || c == '-';
}

// "--Name.key" at the start of a line (after spaces, and after a short form as
// in "-h [ --help ]").
void CollectOption(std::string_view line, std::set<std::string>* options) {
  const size_t start = line.find("--");
  if (start == std::string_view::npos) return;
  for (const char c : line.substr(0, start)) {
    // A dash inside a sentence is not an option.
    if (c != ' ' && c != '\t' && c != '-' && c != '[' && c != 'h') return;
  }
  size_t end = start + 2;
  while (end < line.size() && IsOptionCharacter(line[end])) ++end;
  if (end > start + 2) {
    options->emplace(line.substr(start + 2, end - start - 2));
  }
}

// "COLMAP 3.8 -- Structure-from-Motion ..." -> "3.8".
std::string VersionIn(std::string_view line) {
  constexpr std::string_view kName = "COLMAP ";
  const size_t at = line.find(kName);
  if (at == std::string_view::npos) return {};
  const size_t start = at + kName.size();
  size_t end = start;
  while (end < line.size() && line[end] != ' ') ++end;
  if (end == start ||
      std::isdigit(static_cast<unsigned char>(line[start])) == 0)
    return {};
  return std::string(line.substr(start, end - start));
}

// The first three numbers of "4.1.0" or "3.9-dev"; missing ones are 0.
std::array<int, 3> VersionNumbers(const std::string& version) {
  std::array<int, 3> numbers = {};
  size_t at = 0;
  for (int& number : numbers) {
    for (; at < version.size() &&
           std::isdigit(static_cast<unsigned char>(version[at])) != 0;
         ++at) {
      number = std::min(number * 10 + (version[at] - '0'), 1 << 20);
    }
    if (at == version.size() || version[at] != '.') break;
    ++at;
  }
  return numbers;
}

}  // namespace

std::vector<std::string> ColmapProgram::KnownFaults() const {
  std::vector<std::string> faults;
  if (version_ == "unknown") return faults;
  const std::array<int, 3> number = VersionNumbers(version_);
  if (number < std::array{3, 8, 0}) {
    faults.push_back("COLMAP " + version_ +
                     " is older than 3.8, the oldest release that is tested; "
                     "install a newer one");
  }
  // Source: COLMAP's CHANGELOG.rst, release 4.1.1.
  if (number >= std::array{4, 0, 0} && number < std::array{4, 1, 1}) {
    faults.push_back("COLMAP " + version_ +
                     " verifies matches 4 to 6 times slower than other "
                     "releases; install 4.1.1 or newer");
    faults.push_back("COLMAP " + version_ +
                     " rescales photos without distortion wrongly when "
                     "undistort.max_image_size is set and only some cameras "
                     "have distortion; install 4.1.1 or newer");
  }
  return faults;
}

StatusOr<ColmapProgram> ColmapProgram::Find(
    const std::string& program, const CancellationToken* cancellation) {
  ColmapProgram result;
  result.program_ = program;
  bool is_colmap = false;
  const auto on_line = [&](std::string_view line) {
    if (line.find("COLMAP") != std::string_view::npos) is_colmap = true;
    if (result.version_.empty()) result.version_ = VersionIn(line);
  };
  ChildCommand help = result.Command("help");
  help.time_limit_s = kHelpSeconds;
  const StatusOr<ChildResult> outcome = RunChild(help, on_line, cancellation);
  if (!outcome.ok()) {
    if (outcome.status().code() == StatusCode::kMissingDependency) {
      return MissingDependencyError(outcome.status().message() + "; " +
                                    kAdvice);
    }
    return outcome.status();
  }
  if (!is_colmap) {
    return MissingDependencyError(
        "'" + program + " help' ended with " + outcome->Describe() +
        " and does not say that it is COLMAP; " + kAdvice);
  }
  if (result.version_.empty()) result.version_ = "unknown";
  return result;
}

StatusOr<std::set<std::string>> ColmapProgram::Options(
    const std::string& command, const CancellationToken* cancellation) {
  const auto known = options_.find(command);
  if (known != options_.end()) return known->second;

  ChildCommand child = Command(command);
  child.argv.push_back("--help");
  child.time_limit_s = kHelpSeconds;
  std::set<std::string> options;
  FREEGS_ASSIGN_OR_RETURN(
      const ChildResult result,
      RunChild(
          child,
          [&](std::string_view line) { CollectOption(line, &options); },
          cancellation));
  if (options.size() < 2) {
    return MissingDependencyError(
        "COLMAP " + version_ + ": '" + program_ + " " + command +
        " --help' lists no options (" + result.Describe() + "); " + kAdvice);
  }
  options_[command] = options;
  return options;
}

ChildCommand ColmapProgram::Command(const std::string& command) const {
  ChildCommand child;
  child.argv = {program_, command};
  // COLMAP links Qt, which ends the program when there is no display.
  child.environment = {{"QT_QPA_PLATFORM", "offscreen"}};
  return child;
}

void ColmapArguments::Require(const std::string& option,
                              const std::string& value) {
  if (!Prefer({option}, value) && missing_.empty()) missing_ = option;
}

bool ColmapArguments::Prefer(std::initializer_list<std::string> names,
                             const std::string& value) {
  for (const std::string& name : names) {
    if (!options_.contains(name)) continue;
    command_.argv.push_back("--" + name);
    command_.argv.push_back(value);
    return true;
  }
  return false;
}

void ColmapArguments::AddAll(std::initializer_list<std::string> names,
                             const std::string& value) {
  for (const std::string& name : names) Prefer({name}, value);
}

StatusOr<ChildCommand> ColmapArguments::Finish() const {
  if (missing_.empty()) return command_;
  return MissingDependencyError(
      "'" + command_.argv[0] + " " + command_.argv[1] + "' has no option --" +
      missing_ + "; this release of COLMAP is not supported, use 3.8 or newer");
}

}  // namespace freegs::sfm
