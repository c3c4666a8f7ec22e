// SPDX-License-Identifier: BSD-3-Clause
// A reconstructed scene, its patches, and what is known of them.

#ifndef FREEGS_BENCH_EVIDENCE_LEARNING_SCENE_H_
#define FREEGS_BENCH_EVIDENCE_LEARNING_SCENE_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/instances/hierarchy.h"
#include "semantics/patches/evidence_model.h"
#include "semantics/patches/scene_patches.h"

namespace freegs::evidence {

// Numbers of true segments below this one are objects, others are surfaces of
// the room.
inline constexpr int kFirstSurface = 200;

// With one division into patches.
struct LearningScene {
  std::string name;
  semantics::ScenePatches patches;

  // In the views that have true masks: the pixels of each patch, those that are
  // in each true segment, and all of each segment. Segments may overlap, as
  // masks of parts do.
  std::vector<double> pixels;
  std::vector<std::map<int, double>> votes;
  std::map<int, double> segment_pixels;

  // The patch of each pixel in a few of these views, -1 for none.
  std::vector<std::pair<std::string, Image<int32_t>>> pictures;
};

// The segment that most of a region's pixels are of, -1 if it is of none.
int TrueSegment(const std::map<int, double>& votes, double pixels);

// The votes of two regions together.
std::map<int, double> SumOfVotes(std::map<int, double> votes,
                                 const std::map<int, double>& others);

// truth: a folder of freegs_make_scene, or one with test_mask/VIEW/LABEL.png.
// with_semantics: patches get the vectors of the workspace's
// bootstrap/idsf.bin. Returns the scene with each division, semantics::
// kNumDivisions in all, under the name of the workspace's folder. kBadInput
// names a truth without a mask of any of the workspace's photos.
StatusOr<std::vector<LearningScene>> LoadLearningScene(
    const std::filesystem::path& workspace,
    const std::filesystem::path& truth,
    bool with_semantics,
    ThreadPool& pool);

}  // namespace freegs::evidence

#endif  // FREEGS_BENCH_EVIDENCE_LEARNING_SCENE_H_
