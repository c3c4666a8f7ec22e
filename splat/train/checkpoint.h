// SPDX-License-Identifier: BSD-3-Clause
// Everything that training needs to go on as if it had not stopped.

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
#include "splat/optim/adam.h"
#include "splat/density/densification.h"
#include "splat/scene/gaussian_model.h"
#include "splat/train/training_history.h"

namespace freegs::splat {

// Random numbers are counter-based, so no generator state is part of it.
struct TrainingCheckpoint {
  int64_t iteration = 0;  // Iterations done.
  double elapsed_seconds = 0;
  GaussianModel model;
  AdamState adam;
  DensificationStatistics statistics;
  TrainingHistory history;

  // Whatever else the trainer wants back, as text.
  std::map<std::string, std::string> facts;
};

// The file's content: magic, version, payload of little-endian arrays, and a
// hash of all before it, so that any damage is noticed. A file of another
// version is refused: kBadInput, naming both.
std::string SerializeCheckpoint(const TrainingCheckpoint& checkpoint);
StatusOr<TrainingCheckpoint> ParseCheckpoint(std::string_view content);

// Writes folder/iteration_NNNNNNNN.ckpt atomically, creates the folder when it
// is missing, then removes all but the newest `keep` checkpoints in it.
Status SaveCheckpoint(const std::filesystem::path& folder,
                      const TrainingCheckpoint& checkpoint,
                      int keep = 2);

// kBadInput, naming file and fault, when the file is damaged.
StatusOr<TrainingCheckpoint> LoadCheckpoint(const std::filesystem::path& path);

// The newest checkpoint in the folder that is whole; nothing when there is none
// or no folder. What was wrong with newer ones is appended to `problems`, if
// given.
std::optional<TrainingCheckpoint> LatestCheckpoint(
    const std::filesystem::path& folder,
    std::vector<std::string>* problems = nullptr);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TRAIN_CHECKPOINT_H_
