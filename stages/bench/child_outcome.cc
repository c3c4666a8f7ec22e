// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bench/child_outcome.h"

#include <algorithm>
#include <array>
#include <limits>
#include <sstream>
#include <string_view>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_fields.h"
#include "core/io/json_text.h"
#include "core/text.h"
#include "pipeline/exit_code.h"
#include "sfm/colmap/child_process.h"

namespace freegs::stages {
namespace {

constexpr size_t kMaxSaid = 10;
constexpr size_t kMaxLine = 2000;
constexpr std::string_view kErrorPrefix = "freegs_pipeline: ";

}  // namespace

bool ChildOutcome::IsFinal(double limit_s) const {
  return exit_code == 0 ||
         exit_code == pipeline::ExitCode(StatusCode::kBadInput) ||
         exit_code == pipeline::ExitCode(StatusCode::kUnusableResult) ||
         (timed_out && limit_s > 0 && limit_s <= time_limit_s);
}

std::string KindOfLine(const std::string& line) {
  std::string kind;
  bool begins_word = true;  // Whether the last number is the start of a word.
  for (const char c : line) {
    const bool after_number = kind.ends_with('#');
    if (IsDigit(c)) {
      if (after_number) continue;
      begins_word = kind.empty() || std::string_view(" '\"(").find(
                                        kind.back()) != std::string_view::npos;
      kind += '#';
    } else if (c == '/' && after_number && begins_word) {
      kind.pop_back();
    } else {
      kind += c;
    }
  }
  return kind;
}

StatusOr<ChildOutcome> RunForOutcome(const std::vector<std::string>& argv,
                                     const BenchContext& context) {
  ChildOutcome outcome;
  std::set<std::string> kinds;
  const auto on_line = [&outcome, &kinds](std::string_view line) {
    line = line.substr(0, kMaxLine);
    const bool error = line.starts_with(kErrorPrefix);
    if (error) outcome.reason = line.substr(kErrorPrefix.size());
    if (!error && !line.starts_with("warning: ") &&
        !line.starts_with("error: ")) {
      return;
    }
    outcome.said.emplace_back(line);
    if (kinds.insert(KindOfLine(outcome.said.back())).second) {
      outcome.kinds.emplace_back(line);
    }
    // The first lines and the last.
    if (outcome.said.size() > kMaxSaid) {
      outcome.said.erase(outcome.said.begin() + kMaxSaid / 2);
    }
  };
  sfm::ChildCommand command;
  command.argv = argv;
  command.time_limit_s = context.time_limit_s;
  FREEGS_ASSIGN_OR_RETURN(
      const sfm::ChildResult result,
      sfm::RunChild(command, on_line, context.cancellation));
  outcome.exit_code = result.ok() ? 0 : result.exit_code;
  outcome.timed_out = result.timed_out;
  outcome.time_limit_s = context.time_limit_s;
  if (result.ok()) {
    outcome.reason.clear();
  } else if (outcome.reason.empty() || result.timed_out || result.signal != 0) {
    outcome.reason = result.Describe();
  }
  return outcome;
}

std::string ProgramsText(const std::set<std::string>& programs) {
  std::string text;
  for (const std::string& program : programs) {
    text += (text.empty() ? "" : "+") + program;
  }
  return text;
}

std::set<std::string> ParsePrograms(const std::string& text) {
  std::set<std::string> programs;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, '+');) {
    programs.insert(part);
  }
  return programs;
}

Status WriteOutcome(const std::filesystem::path& path,
                    const ChildOutcome& outcome) {
  const nlohmann::json json = {{"exit_code", outcome.exit_code},
                               {"reason", outcome.reason},
                               {"timed_out", outcome.timed_out},
                               {"time_limit_s", outcome.time_limit_s},
                               {"said", outcome.said},
                               {"kinds", outcome.kinds},
                               {"program", ProgramsText(outcome.programs)}};
  return WriteFileAtomic(path, JsonText(json));
}

StatusOr<ChildOutcome> ReadOutcome(const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const nlohmann::json json, ReadJson(path));
  Status status;
  JsonObjectReader reader(json, path.string(), "", &status);
  ChildOutcome outcome;
  outcome.exit_code = reader.Integer("exit_code", -1, 255);
  outcome.reason = reader.Text("reason");
  outcome.timed_out = reader.Bool("timed_out");
  // Earlier programs did not write it; what timed out then is tried again.
  if (reader.Has("time_limit_s")) {
    outcome.time_limit_s =
        reader.Number("time_limit_s", 0, std::numeric_limits<double>::max());
  }
  outcome.said = reader.TextList("said");
  // Earlier programs did not write it.
  outcome.kinds = reader.Has("kinds") ? reader.TextList("kinds") : outcome.said;
  outcome.programs = ParsePrograms(reader.Text("program"));
  FREEGS_RETURN_IF_ERROR(status);
  return outcome;
}

}  // namespace freegs::stages
