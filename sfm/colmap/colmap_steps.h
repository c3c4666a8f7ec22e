// SPDX-License-Identifier: BSD-3-Clause
// The single steps of structure from motion: features, matches, mapping. Used
// by structure_from_motion.cc, which knows their order and what is done.

#ifndef FREEGS_SFM_COLMAP_COLMAP_STEPS_H_
#define FREEGS_SFM_COLMAP_COLMAP_STEPS_H_

#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/status.h"
#include "sfm/colmap/colmap_program.h"
#include "sfm/matching/descriptor_matching.h"
#include "sfm/colmap/sfm_options.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// What every step needs.
struct StepContext {
  const SfmInput& input;
  const SfmOptions& options;
  ColmapProgram& colmap;
  int num_threads = 1;

  // How much alike descriptors must be (see descriptor_matching.h).
  DescriptorMatchingOptions matching = {};

  // SIFT's least contrast; 0 for COLMAP's default.
  double peak_threshold = 0;

  std::filesystem::path LogFile(const std::string& command) const;
  // For the arguments of a command that writes its own log and is taken for
  // stuck after TimeLimit(photos).
  StatusOr<ColmapArguments> Arguments(const std::string& command,
                                      size_t photos) const;
  void Report(const std::string& step,
              double done,
              double total,
              const std::string& detail) const;
};

// kUnusableResult with the last lines of output unless the program ended well.
Status CheckEnded(const StepContext& context,
                  const std::string& command,
                  const ChildResult& result);

// Makes a new database that knows the photos, in the order given, and their
// cameras, without features. Returns false, having done nothing, when this
// COLMAP cannot do that; ExtractFeatures then runs with one thread.
StatusOr<bool> RegisterPhotos(const StepContext& context,
                              const std::filesystem::path& database);

// Adds the features of all photos that have none yet.
Status ExtractFeatures(const StepContext& context,
                       const std::filesystem::path& database,
                       int num_threads);

// The size of images, in pixels, that is enough for options.max_features: from
// 800 to 1600, by the features that a few of the photos have at 800.
StatusOr<int> ChooseImageSize(const StepContext& context);

// The same for photos that have `found` features at 800.
int ImageSizeFor(int64_t found, int max_features);

// Matches the pairs that options.pairs choose into the database, in portions,
// and writes pairs.txt, their list, beside it.
// `done` are the numbers of portions that earlier calls finished; on_done is
// told about each more.
StatusOr<MatchedPairs> MatchFeatures(
    const StepContext& context,
    const std::filesystem::path& database,
    const std::set<int>& done,
    const std::function<Status(int portion)>& on_done);

// Gives pairs that are matched, by ids of photos, the further matches that
// COLMAP finds along their epipolar lines ("guided matching").
// kMissingDependency when this COLMAP cannot.
Status MatchGuided(const StepContext& context,
                   const std::filesystem::path& database,
                   const std::vector<std::pair<uint32_t, uint32_t>>& pairs);

// A time after which a COLMAP command that works on so many photos, or twenty
// times as many pairs, is taken for stuck; seconds.
double TimeLimit(size_t photos);

// One way to make models from a database.
struct Mapping {
  std::string step = "mapping";    // What the user is told.
  std::string command = "mapper";  // Or hierarchical_mapper, global_mapper.

  // With thresholds for few or weakly connected photos.
  bool relaxed = false;

  // Other random draws.
  uint64_t seed_offset = 0;

  // Photos are added to this model, a folder, instead of starting anew.
  std::filesystem::path start;
};

// Maps, in a new folder that is deleted again: the models that came of it, the
// largest first; maybe none.
StatusOr<std::vector<Reconstruction>> MapPhotos(
    const StepContext& context,
    const std::filesystem::path& database,
    const std::filesystem::path& folder,
    const Mapping& mapping);

// How many photos the largest of the models has; 0 without any.
inline size_t NumRegistered(const std::vector<Reconstruction>& models) {
  return models.empty() ? 0 : models[0].images.size();
}

// Maps, and again with lower thresholds when that leaves out many of the photos
// wanted; the larger result. Its folder as for MapPhotos.
StatusOr<std::vector<Reconstruction>> MapBest(
    const StepContext& context,
    const std::filesystem::path& database,
    const std::filesystem::path& folder,
    size_t wanted);

// Puts two models that share photos into one frame, without adjusting it, and
// writes it to a folder. False when COLMAP finds no way to do so.
StatusOr<bool> MergeModels(const StepContext& context,
                           const std::filesystem::path& model1,
                           const std::filesystem::path& model2,
                           const std::filesystem::path& merged);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_COLMAP_COLMAP_STEPS_H_
