// SPDX-License-Identifier: BSD-3-Clause
// The training inside stage reconstruct, with its checkpoints, measurements and
// log lines.

#ifndef FREEGS_STAGES_RECONSTRUCT_TRAINING_RUN_H_
#define FREEGS_STAGES_RECONSTRUCT_TRAINING_RUN_H_

#include <cstdint>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/status.h"
#include "pipeline/stage.h"
#include "splat/images/training_images.h"
#include "splat/optim/exposure.h"
#include "splat/scene/gaussian_model.h"
#include "splat/train/trainer.h"
#include "stages/reconstruct/reconstruct_options.h"
#include "stages/reconstruct/training_report.h"
#include "stages/scene/training_scene.h"

namespace freegs::stages {

struct TrainedModel {
  splat::GaussianModel model;
  int64_t iterations = 0;

  // What was learnt about the photos' exposure, in the order of NaturalLess;
  // empty where it was not.
  std::vector<splat::PhotoExposure> exposures;

  // What CourseJson says about the training.
  nlohmann::json course = CourseJson("", nullptr);
};

// Trains a model of the scene. Writes progress.csv and checkpoints/ below
// context.output, and starts from the newest whole checkpoint there when
// context.resuming is true: the model has the same bytes as after a run without
// interruption. Without holdout photos nothing is measured. The errors are
// kInterrupted on cancellation, and those of splat::Trainer and
// splat::SearchExposure. A cancelled training saves a checkpoint first; a
// cancelled search about exposure does not, and is made anew. If the time of a
// run is up before the search ends, exposure is not learnt; the few steps of
// such a training leave no checkpoint, so that a resumed run searches again.
StatusOr<TrainedModel> TrainModel(const ReconstructStageOptions& options,
                                  const splat::TrainerOptions& training,
                                  const TrainingScene& scene,
                                  splat::TrainingImages* images,
                                  std::optional<splat::TrainingImages>* holdout,
                                  pipeline::StageContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RECONSTRUCT_TRAINING_RUN_H_
