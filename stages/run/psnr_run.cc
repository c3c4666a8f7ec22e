// SPDX-License-Identifier: BSD-3-Clause

#include "stages/run/psnr_run.h"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <iterator>
#include <limits>
#include <string>
#include <system_error>
#include <utility>

#include "core/number_text.h"
#include "stages/registry/presets.h"

namespace freegs::stages {
namespace {

using pipeline::LogLevel;
using pipeline::OptionSetting;

// A training, and by how many dB it is taken to be better than the one before.
// docs/speed_accuracy.md, "At least so accurate", has what seven scenes gained.
struct Rung {
  int iterations;
  double gain;
};

constexpr Rung kRungs[] = {
    {.iterations = 625, .gain = 0},
    {.iterations = 1250, .gain = 1.0},
    {.iterations = 2500, .gain = 0.6},
    {.iterations = 5000, .gain = 0.3},
};

std::vector<OptionSetting> SettingsOf(const Rung& rung) {
  return {
      {"reconstruct.iterations", std::to_string(rung.iterations), "--at-least"},
      {"reconstruct.densify_interval",
       std::to_string(DensifyInterval(rung.iterations)),
       "--at-least"}};
}

// A run ends where two trainings foretell that the goal is missed by more dB
// than this. What is foretold from one may be far off, so it never ends a run.
constexpr double kMargin = 0.5;

std::string IterationsText(const Rung& rung) {
  return FormatCount(rung.iterations) + " iterations";
}

// What earlier runs have left to begin with.
struct Start {
  // A training that is done, and the PSNR it gave.
  std::optional<size_t> rung;
  double psnr = 0;

  // A longer one that was interrupted.
  std::optional<size_t> begun;
};

StatusOr<Start> FindStart(const PsnrRunTasks& tasks) {
  Start start;
  for (size_t rung = 0; rung < std::size(kRungs); ++rung) {
    FREEGS_ASSIGN_OR_RETURN(const TrainingState state,
                            tasks.look(SettingsOf(kRungs[rung])));
    if (state.psnr && !start.rung) {
      start.rung = rung;
      start.psnr = *state.psnr;
    }
    if (state.begun) start.begun = rung;
  }
  // Otherwise the first training begins in its place.
  if (!start.rung) start.begun.reset();
  return start;
}

double GainBetween(size_t from, size_t to) {
  double gain = 0;
  for (size_t k = from + 1; k <= to; ++k) gain += kRungs[k].gain;
  return gain;
}

}  // namespace

StatusOr<double> ParsePsnrGoal(std::string_view text) {
  constexpr std::string_view kName = "psnr=";
  constexpr double kMost = 100;
  double psnr = 0;
  if (text.starts_with(kName)) {
    const std::string_view number = text.substr(kName.size());
    const char* const end = number.data() + number.size();
    const auto [after, error] =
        std::from_chars(number.data(), end, psnr, std::chars_format::fixed);
    // from_chars also takes "inf" and "nan".
    if (error == std::errc() && after == end && psnr >= 1 && psnr <= kMost) {
      return psnr;
    }
  }
  return InvalidArgumentError("'" + std::string(text) +
                              "' is no accuracy; write psnr=27, in dB");
}

bool IsChosenByPsnr(std::string_view option) {
  const std::vector<OptionSetting> chosen = SettingsOf(kRungs[0]);
  return std::ranges::any_of(chosen, [option](const OptionSetting& setting) {
    return setting.name == option;
  });
}

Status ChosenByPsnrError(const std::string& option) {
  return InvalidArgumentError(option +
                              " is what --at-least chooses; leave it out");
}

Status RunAtLeast(double psnr, const PsnrRunTasks& tasks) {
  const std::string goal =
      "run: at least " + FormatSignificant(psnr, 4) + " dB: ";
  // What is barely missed must not look reached.
  const auto as_text = [psnr](double reached) {
    return FormatFixed(reached, DecimalsApart(reached, psnr, 1)) + " dB";
  };
  constexpr size_t kLast = std::size(kRungs) - 1;
  size_t rung = 0;
  // How much longer trainings gain in this scene, relative to what others gain;
  // known after two trainings.
  double scale = 1;
  double margin = std::numeric_limits<double>::infinity();
  FREEGS_ASSIGN_OR_RETURN(Start start, FindStart(tasks));
  double reached = 0;
  if (start.rung) {
    rung = *start.rung;
    reached = start.psnr;
    tasks.log(LogLevel::kInfo,
              goal + "begins with what there is, a training of " +
                  IterationsText(kRungs[rung]));
  } else {
    tasks.log(
        LogLevel::kInfo,
        goal + "begins with a training of " + IterationsText(kRungs[rung]));
    FREEGS_ASSIGN_OR_RETURN(reached, tasks.train(SettingsOf(kRungs[rung])));
  }
  while (reached < psnr && rung < kLast) {
    // The shortest training that is expected to be enough, or the one that was
    // interrupted: any other would begin in its place, and what it has done
    // would be lost. An earlier run may have known more when it chose it.
    size_t next = rung + 1;
    if (start.begun.value_or(0) > rung) {
      next = *std::exchange(start.begun, std::nullopt);
    } else {
      while (next < kLast && reached + scale * GainBetween(rung, next) < psnr) {
        ++next;
      }
    }
    const double expected = reached + scale * GainBetween(rung, next);
    const std::string outlook =
        goal + IterationsText(kRungs[rung]) + " gave " + as_text(reached) +
        ", " + FormatCount(kRungs[next].iterations) + " are expected to give " +
        FormatFixed(expected, 1);
    if (expected < psnr - margin) {
      tasks.log(LogLevel::kWarning, outlook + ", which is not worth trying");
      break;
    }
    tasks.log(LogLevel::kInfo, outlook);
    FREEGS_ASSIGN_OR_RETURN(const double better,
                            tasks.train(SettingsOf(kRungs[next])));
    tasks.log(LogLevel::kInfo,
              goal + IterationsText(kRungs[next]) + " gave " + as_text(better) +
                  ", " + FormatFixed(expected, 1) + " were expected");
    scale = std::clamp((better - reached) / GainBetween(rung, next), 0.0, 2.0);
    margin = kMargin;
    reached = better;
    rung = next;
  }
  FREEGS_RETURN_IF_ERROR(tasks.finish(SettingsOf(kRungs[rung])));
  const bool missed = reached < psnr;
  tasks.log(missed ? LogLevel::kWarning : LogLevel::kInfo,
            goal + "holdout photos have " + (missed ? "only " : "") +
                as_text(reached) + " after " + IterationsText(kRungs[rung]));
  return Status();
}

}  // namespace freegs::stages
