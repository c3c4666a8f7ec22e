// SPDX-License-Identifier: BSD-3-Clause
// What the layouts of LERF-Mask and 3D-OVS have in common: photographs with
// COLMAP's poses, and for each test view a folder of masks, one per phrase.

#ifndef FREEGS_STAGES_DATASETS_MASK_FOLDERS_H_
#define FREEGS_STAGES_DATASETS_MASK_FOLDERS_H_

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/status.h"
#include "stages/evaluation/ground_truth.h"

namespace freegs::stages {

// ROOT/NAME/PHRASE.png (or .jpg): the masks of one test view, by phrase.
struct MaskFolder {
  std::string name;
  std::vector<std::pair<std::string, std::filesystem::path>> masks;
};

// Lists the folders in `root` that hold masks, sorted by name. kBadInput when
// there is none, for phrases of more than 200 bytes or with control characters,
// and for more than 10000 folders.
StatusOr<std::vector<MaskFolder>> ListMaskFolders(
    const std::filesystem::path& root);

// The photographs of a scene folder, in the order in which the benchmarks
// number them: by their names up to the first dot.
struct DatasetPhotos {
  std::vector<std::string> names;
  std::vector<View> views;  // One for each name, or empty without a model.
  std::map<std::string, sfm::Camera> lenses;  // Those that distort, by name.
};

// Reads the photographs' names and cameras from SCENE/sparse/0 or SCENE/sparse.
// Without such a model only the names are known, from SCENE/images. kBadInput
// when neither exists or the model is malformed.
StatusOr<DatasetPhotos> ReadDatasetPhotos(const std::filesystem::path& scene);

// The file names in `folder`, sorted; empty when it is not a folder.
std::vector<std::string> FilesIn(const std::filesystem::path& folder);

// The name without its folders, up to its first dot.
std::string PhotoStem(const std::string& name);

// Builds a truth that has masks but no boxes. `test_views` pairs an index into
// photos.names with the masks of that photograph. Each distinct phrase becomes
// an object; ids follow the order of the phrases. kBadInput when a view has two
// masks of one phrase, and for more than 65535 phrases.
StatusOr<GroundTruth> TruthOfMasks(
    const std::filesystem::path& scene,
    const DatasetPhotos& photos,
    const std::vector<std::pair<size_t, MaskFolder>>& test_views);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_DATASETS_MASK_FOLDERS_H_
