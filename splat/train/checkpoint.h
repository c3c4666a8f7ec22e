// SPDX-License-Identifier: BSD-3-Clause
// Checkpoints: everything that training needs to go on as if it had not
// stopped, written to files.
//
//   SaveCheckpoint("checkpoints", trainer.CheckpointView());
//   ...
//   if (auto checkpoint = LatestCheckpoint("checkpoints")) {
//     FREEGS_RETURN_IF_ERROR(trainer.Restore(*std::move(checkpoint)));
//   }

#ifndef FREEGS_SPLAT_TRAIN_CHECKPOINT_H_
#define FREEGS_SPLAT_TRAIN_CHECKPOINT_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"
#include "splat/density/densification.h"
#include "splat/optim/adam.h"
#include "splat/scene/gaussian_model.h"
#include "splat/train/training_history.h"

namespace freegs::splat {

// There is no state of a random generator: random numbers are functions of seed
// and iteration.
struct TrainingCheckpoint {
  int64_t iteration = 0;  // Number of steps made.
  double elapsed_seconds = 0;
  GaussianModel model;
  AdamState adam;
  DensificationStatistics statistics;
  TrainingHistory history;

  // Further values by name, which the caller wants to have back.
  std::map<std::string, std::string> facts;
};

// A TrainingCheckpoint by reference, for writing: a trainer's state is large.
// The state must not change while the view is in use.
struct TrainingCheckpointView {
  int64_t iteration = 0;
  double elapsed_seconds = 0;
  const GaussianModel* model = nullptr;
  const AdamState* adam = nullptr;
  const DensificationStatistics* statistics = nullptr;
  const TrainingHistory* history = nullptr;
  std::map<std::string, std::string> facts;
};

// The checkpoint must outlive the view.
TrainingCheckpointView ViewOf(const TrainingCheckpoint& checkpoint);

// Whether all arrays are those of as many Gaussians, of the same degree and of
// as many photos, and the last good state is not of a later iteration.
bool IsWhole(const TrainingCheckpoint& checkpoint);

// Converts a checkpoint to the content of a file and back. The content is a
// magic number, a version, the little-endian values, and a hash of all of these
// that reveals any damage. ParseCheckpoint fails with kBadInput when the
// content is damaged or of another version; the message names both versions.
std::string SerializeCheckpoint(const TrainingCheckpoint& checkpoint);
StatusOr<TrainingCheckpoint> ParseCheckpoint(std::string_view content);

// folder/iteration_NNNNNNNN.ckpt, the file of the checkpoint after so many
// steps.
std::filesystem::path CheckpointPath(const std::filesystem::path& folder,
                                     int64_t iteration);

// Writes CheckpointPath atomically, then removes all but the newest `keep`
// checkpoints in the folder, and those of later iterations, which a training
// that diverged has left behind it. Creates the folder when it is missing.
// Makes no copy of the state.
Status SaveCheckpoint(const std::filesystem::path& folder,
                      const TrainingCheckpointView& checkpoint,
                      int keep = 2);

// Reads a checkpoint. Fails with kBadInput, naming the file and the fault, when
// the file cannot be read or is damaged.
StatusOr<TrainingCheckpoint> LoadCheckpoint(const std::filesystem::path& path);

// Returns the newest undamaged checkpoint in the folder, or nothing when there
// is none or no such folder. Appends what is wrong with newer checkpoints to
// *problems unless that is null.
std::optional<TrainingCheckpoint> LatestCheckpoint(
    const std::filesystem::path& folder,
    std::vector<std::string>* problems = nullptr);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TRAIN_CHECKPOINT_H_
