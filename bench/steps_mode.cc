// SPDX-License-Identifier: BSD-3-Clause

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "bench/training_modes.h"
#include "core/quantile.h"
#include "core/random.h"
#include "pipeline/resource_usage.h"
#include "splat/train/trainer.h"
#include "stages/scene/training_scene.h"

namespace freegs::bench {
namespace {

constexpr uint64_t kSeed = 0;

// Offset of a copy in standard deviations of the Gaussian copied.
constexpr double kJitter = 0.3;

// `count` Gaussians of the model: a random choice of them, or all and copies of
// randomly chosen ones, slightly moved.
void SetCount(size_t count, splat::GaussianModel* model) {
  const size_t given = model->size();
  if (count < given) {
    std::vector<uint32_t> indices(given);
    std::iota(indices.begin(), indices.end(), 0);
    for (size_t i = 0; i < count; ++i) {
      std::swap(indices[i], indices[i + RandomIndex(kSeed, 0, i, given - i)]);
    }
    indices.resize(count);
    std::sort(indices.begin(), indices.end());
    model->Select(indices);
    return;
  }
  const splat::GaussianModel original = *model;
  for (size_t i = given; i < count; ++i) {
    model->AppendFrom(original, RandomIndex(kSeed, 1, i, given));
    for (size_t k = 0; k < 3; ++k) {
      model->means[3 * i + k] +=
          static_cast<float>(kJitter * std::exp(model->log_scales[3 * i + k]) *
                             RandomNormal(kSeed, 2 + k, i));
    }
  }
}

// How trainers begin: 30000 steps ahead, SH degree 0 for the first 1000, a
// degree more after each further 1000.
splat::TrainerOptions BeginningOfTraining(int steps) {
  constexpr int kIterations = 30000;
  splat::TrainerOptions options;
  options.schedule.iterations = std::max(steps, kIterations);
  options.schedule.method = splat::DensificationMethod::kNone;
  options.schedule.sh_degree = 3;
  options.schedule.sh_degree_interval = 1000.0 / options.schedule.iterations;
  options.schedule.resolution_steps.clear();
  options.learning_rates.mean_decay_steps = options.schedule.iterations;
  options.seed = kSeed;
  return options;
}

}  // namespace

Status RunSteps(const StepsOptions& options) {
  FREEGS_ASSIGN_OR_RETURN(const stages::TrainingScene scene,
                          stages::ReadTrainingScene(options.workspace));
  FREEGS_ASSIGN_OR_RETURN(splat::GaussianModel initial,
                          stages::InitialModel(scene));
  if (options.gaussians > 0) {
    SetCount(static_cast<size_t>(options.gaussians), &initial);
  }
  ThreadPool pool(options.threads);
  splat::TrainingImagesOptions image_options;
  image_options.max_side = options.max_image_size;
  image_options.num_levels = 1;
  FREEGS_ASSIGN_OR_RETURN(
      splat::TrainingImages images,
      stages::LoadPhotos(scene, scene.photos.train, image_options, pool));
  const Pinhole camera = images.view(0).camera;
  std::fprintf(stderr,
               "%zu photos (first: %d x %d), %zu points, %d threads, %d steps "
               "per round\n",
               images.size(),
               camera.width,
               camera.height,
               scene.points.size(),
               pool.num_threads(),
               options.steps);

  std::printf(
      "round,wall_ms_per_step,cpu_ms_per_step,mean_loss,last_loss,gaussians,"
      "peak_memory_mib\n");
  const splat::TrainerOptions training = BeginningOfTraining(options.steps);
  std::vector<double> wall, cpu;
  double last_mean_loss = 0, last_loss = 0, peak = 0;
  size_t gaussians = 0;
  const auto print = [&](const char* name, double wall_ms, double cpu_ms) {
    std::printf("%s,%.3f,%.3f,%.5f,%.5f,%zu,%.1f\n",
                name,
                wall_ms,
                cpu_ms,
                last_mean_loss,
                last_loss,
                gaussians,
                peak);
    std::fflush(stdout);
  };
  for (int round = 1; round <= options.rounds; ++round) {
    splat::Trainer trainer(training, initial, scene.extent, &images, pool);
    const pipeline::ResourceMeter meter(pipeline::PeakMemory::kReset);
    double loss_sum = 0;
    for (int step = 0; step < options.steps; ++step) {
      FREEGS_ASSIGN_OR_RETURN(const splat::StepReport report, trainer.Step());
      if (report.recovered) {
        return UnusableResultError("training diverged; its time means nothing");
      }
      last_loss = report.loss;
      loss_sum += report.loss;
    }
    const pipeline::ResourceUsage usage = meter.Elapsed();
    wall.push_back(1e3 * usage.wall_seconds / options.steps);
    cpu.push_back(1e3 * usage.cpu_seconds / options.steps);
    last_mean_loss = loss_sum / options.steps;
    peak = std::max(peak,
                    static_cast<double>(usage.peak_memory_bytes) / (1 << 20));
    gaussians = trainer.model().size();
    print(std::to_string(round).c_str(), wall.back(), cpu.back());
  }
  print("median", Median(wall), Median(cpu));
  return Status();
}

}  // namespace freegs::bench
