// SPDX-License-Identifier: BSD-3-Clause

#include "stages/run/time_choice.h"

#include <algorithm>

#include "core/number_text.h"
#include "stages/registry/presets.h"

namespace freegs::stages {
namespace {

// A preset whose iterations may vary.
struct Range {
  int least_iterations;
  int most_iterations;
  int max_image_size;
  int sh_degree;
  const char* budget;
  int max_features;
};

// From the slowest to the fastest: preset quality, the same with smaller images
// so that there is something between it and the next, balanced, and fast. How
// far each range goes was not measured.
constexpr Range kRanges[] = {
    {.least_iterations = 3500,
     .most_iterations = 5000,
     .max_image_size = 1600,
     .sh_degree = 3,
     .budget = "auto",
     .max_features = 4000},
    {.least_iterations = 3000,
     .most_iterations = 5000,
     .max_image_size = 1200,
     .sh_degree = 3,
     .budget = "auto",
     .max_features = 4000},
    {.least_iterations = 1000,
     .most_iterations = 5000,
     .max_image_size = 800,
     .sh_degree = 2,
     .budget = "auto",
     .max_features = 3000},
    {.least_iterations = 300,
     .most_iterations = 2000,
     .max_image_size = 640,
     .sh_degree = 2,
     .budget = "auto:50000",
     .max_features = 1200},
};

constexpr int kIterationSteps = 50;

StatusOr<TimeChoice> Choose(const Range& range,
                            int iterations,
                            const ForetellFn& foretell) {
  TimeChoice choice;
  const auto set = [&choice](const char* name, const std::string& value) {
    choice.settings.push_back({name, value, "--within"});
  };
  set("sfm.max_features", std::to_string(range.max_features));
  set("reconstruct.iterations", std::to_string(iterations));
  set("reconstruct.max_image_size", std::to_string(range.max_image_size));
  set("reconstruct.sh_degree", std::to_string(range.sh_degree));
  set("reconstruct.budget", range.budget);
  set("reconstruct.densify_interval",
      std::to_string(DensifyInterval(iterations)));
  FREEGS_ASSIGN_OR_RETURN(choice.expected, foretell(choice.settings));
  return choice;
}

}  // namespace

std::string TrainingText(const ExpectedRun& expected) {
  return FormatCount(expected.iterations) + " iterations with images of " +
         (expected.max_image_size > 0
              ? "up to " + std::to_string(expected.max_image_size) + " pixels"
              : "full size");
}

StatusOr<TimeChoice> ChooseWithin(double seconds, const ForetellFn& foretell) {
  TimeChoice least;
  for (const Range& range : kRanges) {
    FREEGS_ASSIGN_OR_RETURN(least,
                            Choose(range, range.least_iterations, foretell));
    const double shortest = least.expected.total();
    if (shortest > seconds) continue;
    FREEGS_ASSIGN_OR_RETURN(TimeChoice choice,
                            Choose(range, range.most_iterations, foretell));
    int steps =
        (range.most_iterations - range.least_iterations) / kIterationSteps;
    // The seconds grow nearly in proportion to the iterations, so the first
    // guess mostly fits. Where the fewest iterations are done already and take
    // no time, any more of them may take too long.
    while (choice.expected.total() > seconds) {
      const double share =
          (seconds - shortest) / (choice.expected.total() - shortest);
      steps = std::min(steps - 1, static_cast<int>(share * steps));
      if (steps <= 0) return least;
      FREEGS_ASSIGN_OR_RETURN(
          choice,
          Choose(range,
                 range.least_iterations + steps * kIterationSteps,
                 foretell));
    }
    return choice;
  }
  least.fits = false;
  return least;
}

}  // namespace freegs::stages
