// SPDX-License-Identifier: BSD-3-Clause
// The last steps of structure from motion: the cameras of the best model are
// chosen, all is adjusted with them, and further mappings tell which photos
// would be elsewhere if the mapping had begun with others.

#ifndef FREEGS_SFM_MAPPING_MODEL_REFINEMENT_H_
#define FREEGS_SFM_MAPPING_MODEL_REFINEMENT_H_

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/status.h"
#include "sfm/calibration/camera_selection.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/diagnosis/diagnosis.h"
#include "sfm/diagnosis/evidence.h"
#include "sfm/mapping/attempt.h"
#include "sfm/mapping/confirm_poses.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

struct RefinedModels {
  std::vector<Reconstruction> models;  // The best first; may be empty.

  // The cameras among which that of models[0] was chosen; empty if there was no
  // choice, or if models[0] comes from a further mapping and its cameras could
  // not be chosen once more.
  std::vector<CameraCandidate> camera_models;

  std::vector<Attempt> attempts;  // Further mappings, in order.
  std::vector<std::string> warnings;
};

//   ModelRefinement refinement(context, database, options, diagnosis, &store);
//   FREEGS_ASSIGN_OR_RETURN(RefinedModels refined,
//                           refinement.Run(std::move(models), &evidence));
class ModelRefinement {
 public:
  // `options` are those with which the models were mapped. The references must
  // outlive it.
  ModelRefinement(const StepContext& context,
                  const std::filesystem::path& database,
                  const MapperOptions& options,
                  const DiagnosisOptions& diagnosis,
                  AttemptStore* store)
      : context_(context),
        database_(database),
        options_(options),
        diagnosis_(diagnosis),
        store_(store) {}

  // `models` are the best first; there may be none. Writes into the evidence
  // which photos are uncertain, and takes those from the unplaced ones that
  // have a place after all. Errors: those of the database, kInterrupted and
  // kInternal.
  StatusOr<RefinedModels> Run(std::vector<Reconstruction> models,
                              SceneEvidence* evidence) const;

 private:
  // What the cameras of a model were chosen from, and why they were not.
  struct CameraChoice {
    std::vector<CameraCandidate> candidates;
    std::string problem;
  };

  StatusOr<CameraChoice> ChooseCameras(const CameraGroups* groups,
                                       Reconstruction* model) const;
  bool AreOfNoUse(const SceneEvidence& evidence,
                  const std::vector<Reconstruction>& models) const;
  StatusOr<bool> CanMapAgain(const SceneEvidence& evidence,
                             const std::vector<Reconstruction>& models) const;
  StatusOr<std::optional<AttemptResult>> MapFromLaterPair(
      const std::string& name,
      std::optional<size_t> skip,
      CameraGroups* groups) const;
  Status TakeConfirmed(ConfirmedPoses confirmed,
                       const CameraGroups& groups,
                       SceneEvidence* evidence,
                       CameraChoice* cameras,
                       RefinedModels* refined) const;

  const StepContext& context_;
  const std::filesystem::path& database_;
  const MapperOptions& options_;
  const DiagnosisOptions& diagnosis_;
  AttemptStore* store_;
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_MODEL_REFINEMENT_H_
