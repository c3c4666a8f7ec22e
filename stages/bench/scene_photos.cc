// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bench/scene_photos.h"

#include <algorithm>
#include <system_error>
#include <vector>

#include "core/io/files.h"
#include "stages/bench/child_outcome.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

constexpr char kMaker[] = "freegs_make_scene";
constexpr size_t kFolderHashDigits = 12;

// An empty folder beside `folder`, which is renamed when it is complete, so
// that a killed bench leaves no half of it.
StatusOr<fs::path> FreshPartial(const fs::path& folder) {
  std::error_code error;
  const fs::path partial = folder.string() + ".partial";
  fs::remove_all(partial, error);
  FREEGS_RETURN_IF_ERROR(CreateFolders(folder.parent_path()));
  return partial;
}

Status Complete(const fs::path& partial, const fs::path& folder) {
  std::error_code error;
  fs::rename(partial, folder, error);
  if (!error) return Status();
  return InternalError(partial.string() + ": cannot rename it to " +
                       folder.string() + ": " + error.message());
}

StatusOr<fs::path> Drawn(const SuiteScene& scene, const BenchContext& context) {
  const fs::path maker = context.program.parent_path() / kMaker;
  std::error_code error;
  if (!fs::exists(maker, error)) {
    return MissingDependencyError(
        "[scene " + scene.name + "]: " + maker.string() +
        " draws it and is not there; build the program with "
        "-DFREEGS_BUILD_TESTS=ON");
  }
  FREEGS_ASSIGN_OR_RETURN(std::string key, HashFile(maker));
  for (const std::string& word : scene.draw) key += '\0' + word;
  std::string name = scene.name;
  std::replace(name.begin(), name.end(), ' ', '_');
  const fs::path folder =
      context.out / "scenes" /
      (name + "_" + HashBytes(key).substr(0, kFolderHashDigits));
  if (fs::exists(folder, error)) return folder;
  FREEGS_ASSIGN_OR_RETURN(const fs::path partial, FreshPartial(folder));
  context.say("drawing scene " + scene.name);
  std::vector<std::string> argv = {maker.string(), "--out", partial.string()};
  argv.insert(argv.end(), scene.draw.begin(), scene.draw.end());
  FREEGS_ASSIGN_OR_RETURN(const ChildOutcome outcome,
                          RunForOutcome(argv, context));
  if (!outcome.ok() || !fs::is_directory(partial / "images", error)) {
    return BadInputError("[scene " + scene.name + "] draw: " + kMaker +
                         " ended with " + outcome.reason +
                         "; call it by hand to see why");
  }
  FREEGS_RETURN_IF_ERROR(Complete(partial, folder));
  return folder;
}

}  // namespace

StatusOr<ScenePhotos> FindScenePhotos(const SuiteScene& scene,
                                      const BenchContext& context) {
  std::error_code error;
  if (!scene.draw.empty()) {
    FREEGS_ASSIGN_OR_RETURN(const fs::path folder, Drawn(scene, context));
    return ScenePhotos{folder / "images", folder, folder};
  }
  const std::string where = "[scene " + scene.name + "] ";
  if (!fs::exists(scene.images, error)) {
    return BadInputError(where + "images: " + scene.images.string() +
                         ": no such folder of photos, and no such film");
  }
  if (!scene.truth.empty() && !fs::is_directory(scene.truth, error)) {
    return BadInputError(where + "truth: " + scene.truth.string() +
                         ": no such folder");
  }
  return ScenePhotos{
      scene.images,
      scene.truth,
      scene.truth.empty() ? scene.images.parent_path() : scene.truth};
}

StatusOr<fs::path> Disturbed(const DisturbSource& source,
                             const std::string& disturbance,
                             uint64_t seed,
                             const BenchContext& context) {
  const std::string key =
      source.hash + '\0' + disturbance + '\0' + std::to_string(seed);
  const fs::path folder =
      context.out / source.kind / HashBytes(key).substr(0, kFolderHashDigits);
  std::error_code error;
  if (fs::exists(folder, error)) return folder;
  FREEGS_ASSIGN_OR_RETURN(const fs::path partial, FreshPartial(folder));
  FREEGS_RETURN_IF_ERROR(
      context.disturber.disturb(disturbance, source.folder, partial, seed));
  FREEGS_RETURN_IF_ERROR(Complete(partial, folder));
  return folder;
}

}  // namespace freegs::stages
