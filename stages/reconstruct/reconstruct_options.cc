// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/reconstruct_options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <system_error>

namespace freegs::stages {
namespace {

constexpr int64_t kMaxBudget = 1000000000;

// The number of steps that the two factors below are for. 5000 steps with the
// rates of 2500 are 0.5 to 1.4 dB better than with smaller ones, on five scenes
// with images of 480 or 640 pixels. With the sizes of preset quality three
// scenes gain 0.0 to 0.1 dB. Longer trainings were not tried.
double RateSteps(int iterations) {
  return std::max(std::min(iterations, 2500), iterations / 2);
}

// What the learning rates of 3DGS, which suit 30000 steps, are multiplied by.
// Short trainings gain from larger rates: 1000 steps at twice the rates end 1
// dB higher on real photos.
double RateFactor(int iterations) {
  return std::clamp(std::sqrt(8000.0 / RateSteps(iterations)), 1.0, 2.0);
}

// What the rates of positions and sizes are multiplied by on top of that, so
// that half the steps lead as far. At 2000 steps 6 instead of 3 for positions
// costs 0.9 to 1.8 dB, 5 instead of 3 for sizes 0 to 0.3.
double GeometryRateFactor(int iterations) {
  return std::clamp(6000.0 / RateSteps(iterations), 1.0, 3.0);
}

// A model that starts again from depth maps needs thousands of steps to become
// as good as before: after 10000 steps it is still 0.2 dB worse, with 13 %
// fewer Gaussians.
constexpr int kMinIterationsOfDepthReinit = 20000;

// Training photos have so many pixels, at the size of training, for each
// Gaussian of the largest model that they can be asked to determine. With twice
// as many a scene of furniture loses 0.45 dB. Most scenes end far below this
// number, because Gaussians that contribute little are removed
// (docs/performance.md).
constexpr int64_t kPixelsPerGaussian = 75;
constexpr int64_t kMinAutomaticBudget = 5000;
constexpr int64_t kMaxAutomaticBudget = 400000;

// Bytes that training takes for each Gaussian of the budget: a dense model of
// twice as many, with 0.84 GB a million.
constexpr int64_t kBytesPerBudget = 2 * 840;

// What option reconstruct.budget says.
struct Budget {
  bool automatic = false;
  std::optional<int64_t> most;  // Not set: "auto" alone.
};

// Nothing if the text is no budget.
std::optional<Budget> ReadBudget(std::string_view text) {
  Budget budget;
  budget.automatic = text.starts_with("auto");
  if (text == "auto") return budget;
  if (text.starts_with("auto:")) text.remove_prefix(5);
  int64_t most = 0;
  const char* const last = text.data() + text.size();
  const auto [stop, failure] = std::from_chars(text.data(), last, most);
  if (failure != std::errc() || stop != last ||
      most < (budget.automatic ? 1 : 0) || most > kMaxBudget) {
    return std::nullopt;
  }
  budget.most = most;
  return budget;
}

std::string AllowedBudgets() {
  return "auto, auto:N or 0 .. " + std::to_string(kMaxBudget);
}

StatusOr<int64_t> ParseBudget(const std::string& text, int64_t automatic) {
  const std::optional<Budget> budget = ReadBudget(text);
  if (!budget) {
    return InvalidArgumentError("reconstruct.budget is '" + text +
                                "'; allowed: " + AllowedBudgets());
  }
  if (!budget->automatic) return *budget->most;
  return std::min(automatic, budget->most.value_or(automatic));
}

splat::DensificationMethod ParseDensification(const std::string& text) {
  if (text == "gradient") return splat::DensificationMethod::kGradient;
  if (text == "none") return splat::DensificationMethod::kNone;
  return splat::DensificationMethod::kMiniSplatting;
}

void RegisterDensificationOptions(ReconstructStageOptions& options,
                                  pipeline::OptionTable& table) {
  table.Add("reconstruct.densification",
            &options.densification,
            {.help = "How Gaussians are placed. mini_splatting: many, then "
                     "cut down to the important ones. gradient: cloned and "
                     "split where the image asks "
                     "for it (3DGS). none: the points of structure from "
                     "motion.",
             .choices = {"mini_splatting", "gradient", "none"}});
  table.Add(
      "reconstruct.budget",
      &options.budget,
      {.help = "Upper bound of the number of Gaussians of the result. "
               "auto: one for 75 pixels of the training photos; most "
               "scenes end with fewer. auto:N: that, but at most N. 0 is "
               "no bound. gradient and none keep all initial points, "
               "however many.",
       .accepts =
           [](const std::string& text) { return ReadBudget(text).has_value(); },
       .allowed = AllowedBudgets()});
  table.Add(
      "reconstruct.densify_interval",
      &options.densify_interval,
      {.help = "Iterations between densifications; 0 never clones, splits "
               "or removes transparent Gaussians.",
       .min = 0});
  table.Add("reconstruct.densify_gradient",
            &options.densify_gradient,
            {.help = "Gaussians whose mean gradient in the image (which spans "
                     "-1 to 1) is larger are cloned or split.",
             .min = 0});
}

}  // namespace

splat::RenderOptions ReconstructRenderOptions(
    const ReconstructStageOptions& options) {
  splat::RenderOptions render;
  if (options.background == "white") render.background = {1, 1, 1};
  return render;
}

int64_t AutomaticBudget(int64_t train_pixels, int64_t memory_bytes) {
  const int64_t most =
      memory_bytes > 0
          ? std::min(kMaxAutomaticBudget, memory_bytes / 2 / kBytesPerBudget)
          : kMaxAutomaticBudget;
  return std::max(kMinAutomaticBudget,
                  std::min(most, train_pixels / kPixelsPerGaussian));
}

StatusOr<splat::TrainerOptions> MakeTrainerOptions(
    const ReconstructStageOptions& options,
    int64_t train_pixels,
    int64_t memory_bytes,
    uint64_t seed) {
  splat::TrainerOptions training;
  splat::ScheduleOptions& schedule = training.schedule;
  schedule.iterations = options.iterations;
  schedule.method = ParseDensification(options.densification);
  schedule.sh_degree = options.sh_degree;
  schedule.densify_interval = options.densify_interval;
  if (options.iterations < kMinIterationsOfDepthReinit) {
    schedule.depth_reinit_at.clear();
  }
  FREEGS_ASSIGN_OR_RETURN(
      training.budget,
      ParseBudget(options.budget, AutomaticBudget(train_pixels, memory_bytes)));
  training.exposure.learn = options.exposure == "on";
  training.densification.gradient_threshold = options.densify_gradient;
  splat::LearningRateOptions& rates = training.learning_rates;
  rates.mean_decay_steps = options.iterations;
  // The end of the rate of positions is left as it is: it is reached only where
  // nothing is simplified (docs/performance.md, "Fewer steps, larger rates").
  for (double* rate : {&rates.mean_initial,
                       &rates.log_scale,
                       &rates.rotation,
                       &rates.opacity_logit,
                       &rates.sh_dc,
                       &rates.sh_rest}) {
    *rate *= RateFactor(options.iterations);
  }
  for (double* rate :
       {&rates.mean_initial, &rates.mean_final, &rates.log_scale}) {
    *rate *= GeometryRateFactor(options.iterations);
  }
  training.render = ReconstructRenderOptions(options);
  training.antialiased = options.antialiased;
  training.seed = seed;
  FREEGS_RETURN_IF_ERROR(training.Check());
  return training;
}

void RegisterReconstructOptions(ReconstructStageOptions& options,
                                pipeline::OptionTable& table) {
  table.AddSection("reconstruct",
                   "Phase 1: Gaussians are fitted to the photographs.");
  table.Add(
      "reconstruct.iterations",
      &options.iterations,
      {.help = "Gradient steps, one photo each.", .min = 1, .max = 1000000});
  table.Add("reconstruct.max_image_size",
            &options.max_image_size,
            {.help = "Longest side in pixels of the images the splats learn "
                     "from; 0 keeps the photos' own size.",
             .min = 0,
             .max = 100000});
  table.Add("reconstruct.sh_degree",
            &options.sh_degree,
            {.help = "Degree of the spherical harmonics that make colour "
                     "depend on the viewing direction.",
             .min = 0,
             .max = 3});
  RegisterDensificationOptions(options, table);
  table.Add("reconstruct.exposure",
            &options.exposure,
            {.help = "Whether the exposure and white balance of each photo are "
                     "learnt. auto: if a short training on most of the photos "
                     "shows that it helps.",
             .choices = {"auto", "on", "off"}});
  table.Add("reconstruct.background",
            &options.background,
            {.help = "Colour behind the scene, where nothing is. For cut-out "
                     "objects it should be ingest.background.",
             .choices = {"black", "white"}});
  table.Add(
      "reconstruct.antialiased",
      &options.antialiased,
      {.help = "Keep the brightness of Gaussians smaller than a pixel "
               "(the 2D filter of Mip-Splatting): for scenes looked at "
               "from farther away than photographed. point_cloud.ply says "
               "so in a comment that viewers know."});
  table.Add("reconstruct.image_cache_gb",
            &options.image_cache_gb,
            {.help = "Gigabytes of decoded photos kept in memory; more photos "
                     "are read again when needed.",
             .min = 0.01,
             .max = 1e6,
             .affects_result = false});
  table.Add("reconstruct.import",
            &options.import,
            {.help = "A 3DGS .ply or .spz to take instead of training, in the "
                     "frame of the camera poses (an .spz turned by half a turn "
                     "about x, as export writes it).",
             .is_path = true});
}

}  // namespace freegs::stages
