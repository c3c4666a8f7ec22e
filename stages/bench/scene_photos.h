// SPDX-License-Identifier: BSD-3-Clause
// Where the photographs of a cell lie: given, drawn, or disturbed.

#ifndef FREEGS_STAGES_BENCH_SCENE_PHOTOS_H_
#define FREEGS_STAGES_BENCH_SCENE_PHOTOS_H_

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/status.h"
#include "stages/bench/bench_context.h"
#include "stages/suite/suite.h"

namespace freegs::stages {

struct ScenePhotos {
  std::filesystem::path images;  // A folder or a film.
  std::filesystem::path truth;   // Empty when there is none.

  // What ${scene} means in options: the folder of the truth, else that of the
  // photographs.
  std::filesystem::path folder;
};

// Returns the photographs of a scene. A drawn scene is drawn into
// OUT/scenes/NAME_HASH, unless it is there, by the freegs_make_scene beside the
// program; kMissingDependency when there is none. kBadInput when photographs or
// truth do not exist.
StatusOr<ScenePhotos> FindScenePhotos(const SuiteScene& scene,
                                      const BenchContext& context);

// What is to be disturbed: the folder of photographs, or of a COLMAP model.
struct DisturbSource {
  std::filesystem::path folder;
  std::string hash;  // Hash of what lies there, or of how it was made.
  std::string kind;  // "photos" or "poses": the folder of OUT for the result.
};

// Returns the folder of the photographs or of the model after the disturbance,
// which is made in OUT/KIND/HASH unless it is there.
StatusOr<std::filesystem::path> Disturbed(const DisturbSource& source,
                                          const std::string& disturbance,
                                          uint64_t seed,
                                          const BenchContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BENCH_SCENE_PHOTOS_H_
