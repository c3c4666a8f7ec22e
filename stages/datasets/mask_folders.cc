// SPDX-License-Identifier: BSD-3-Clause

#include "stages/datasets/mask_folders.h"

#include <algorithm>
#include <optional>
#include <set>
#include <system_error>

#include "core/io/files.h"
#include "sfm/scene/model_io.h"
#include "sfm/scene/views.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxFolders = 10000;
constexpr size_t kMaxPhraseBytes = 200;
constexpr size_t kMaxPhrases = 65535;
constexpr uint64_t kMaxSide = 65535;

bool IsImage(const fs::path& path) {
  const std::string suffix = LowerSuffix(path);
  return suffix == ".png" || suffix == ".jpg" || suffix == ".jpeg";
}

Status CheckPhrase(const std::string& phrase, const fs::path& folder) {
  const bool printable =
      std::none_of(phrase.begin(), phrase.end(), [](unsigned char c) {
        return c < 0x20 || c == 0x7f;
      });
  if (printable && !phrase.empty() && phrase.size() <= kMaxPhraseBytes) {
    return Status();
  }
  return BadInputError(folder.string() +
                       ": holds a mask whose name is no phrase of at most " +
                       std::to_string(kMaxPhraseBytes) + " printable bytes");
}

StatusOr<DatasetPhotos> PhotosOfModel(const fs::path& folder) {
  FREEGS_ASSIGN_OR_RETURN(const sfm::Reconstruction model,
                          sfm::ReadModel(folder));
  const auto camera_index = sfm::IndexCameras(model);
  DatasetPhotos photos;
  for (const sfm::PosedImage& image : model.images) {
    const sfm::Camera& camera = model.cameras[camera_index.at(image.camera_id)];
    if (camera.width > kMaxSide || camera.height > kMaxSide) {
      return BadInputError(folder.string() + ": camera " +
                           std::to_string(camera.id) + " is of " +
                           std::to_string(camera.width) + " x " +
                           std::to_string(camera.height) +
                           " pixels; at most 65535 a side are accepted");
    }
    View view;
    view.name = image.name;
    view.camera = sfm::PinholeOf(camera);
    view.cam_from_world = image.cam_from_world;
    if (!camera.IsUndistorted()) photos.lenses[view.name] = camera;
    photos.views.push_back(std::move(view));
  }
  std::sort(photos.views.begin(),
            photos.views.end(),
            [](const View& a, const View& b) {
              return std::pair(PhotoStem(a.name), a.name) <
                     std::pair(PhotoStem(b.name), b.name);
            });
  for (const View& view : photos.views) photos.names.push_back(view.name);
  return photos;
}

}  // namespace

std::string PhotoStem(const std::string& name) {
  const std::string file = fs::path(name).filename().string();
  return file.substr(0, file.find('.'));
}

std::vector<std::string> FilesIn(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  fs::directory_iterator entry(folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    std::error_code ignored;
    if (entry->is_regular_file(ignored)) {
      names.push_back(entry->path().filename().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

StatusOr<std::vector<MaskFolder>> ListMaskFolders(const fs::path& root) {
  std::vector<MaskFolder> folders;
  std::error_code error;
  fs::directory_iterator entry(root, error);
  if (error) {
    return BadInputError(root.string() +
                         ": cannot be read: " + error.message());
  }
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    std::error_code ignored;
    if (!entry->is_directory(ignored)) continue;
    MaskFolder folder;
    folder.name = entry->path().filename().string();
    for (const std::string& file : FilesIn(entry->path())) {
      if (!IsImage(file)) continue;
      const std::string phrase = fs::path(file).stem().string();
      FREEGS_RETURN_IF_ERROR(CheckPhrase(phrase, entry->path()));
      folder.masks.emplace_back(phrase, entry->path() / file);
    }
    if (!folder.masks.empty()) folders.push_back(std::move(folder));
    if (folders.size() > kMaxFolders) {
      return BadInputError(root.string() + ": more than " +
                           std::to_string(kMaxFolders) + " folders of masks");
    }
  }
  if (error) {
    return BadInputError(root.string() +
                         ": cannot be read: " + error.message());
  }
  if (folders.empty()) {
    return BadInputError(root.string() +
                         ": holds no folder with masks (VIEW/PHRASE.png)");
  }
  std::sort(
      folders.begin(),
      folders.end(),
      [](const MaskFolder& a, const MaskFolder& b) { return a.name < b.name; });
  return folders;
}

StatusOr<DatasetPhotos> ReadDatasetPhotos(const fs::path& scene) {
  for (const fs::path& folder : {scene / "sparse" / "0", scene / "sparse"}) {
    if (sfm::DetectModelFormat(folder)) return PhotosOfModel(folder);
  }
  DatasetPhotos photos;
  for (std::string& name : FilesIn(scene / "images")) {
    if (IsImage(name)) photos.names.push_back(std::move(name));
  }
  if (photos.names.empty()) {
    return BadInputError(scene.string() +
                         ": neither a COLMAP model in sparse/ nor photographs "
                         "in images/");
  }
  std::sort(photos.names.begin(),
            photos.names.end(),
            [](const std::string& a, const std::string& b) {
              return std::pair(PhotoStem(a), a) < std::pair(PhotoStem(b), b);
            });
  return photos;
}

StatusOr<GroundTruth> TruthOfMasks(
    const fs::path& scene,
    const DatasetPhotos& photos,
    const std::vector<std::pair<size_t, MaskFolder>>& test_views) {
  GroundTruth truth;
  truth.folder = scene;
  truth.cameras.train = photos.views;
  std::map<std::string, int> object_of_phrase;
  for (const auto& [photo, folder] : test_views) {
    std::set<std::string> of_view;
    for (const auto& [phrase, file] : folder.masks) {
      object_of_phrase[phrase];
      if (!of_view.insert(phrase).second) {
        return BadInputError(file.string() + ": a second mask of \"" + phrase +
                             "\" in this view");
      }
    }
  }
  if (object_of_phrase.size() > kMaxPhrases) {
    return BadInputError(scene.string() + ": more than " +
                         std::to_string(kMaxPhrases) + " phrases");
  }
  for (auto& [phrase, object] : object_of_phrase) {
    object = static_cast<int>(truth.objects.size()) + 1;
    truth.objects.push_back({object, phrase, std::nullopt});
  }
  for (const auto& [photo, folder] : test_views) {
    const std::string& name = photos.names[photo];
    if (photos.views.empty()) {
      truth.unposed.push_back(name);
    } else {
      truth.cameras.test.push_back(photos.views[photo]);
      const auto lens = photos.lenses.find(name);
      if (lens != photos.lenses.end()) truth.lenses.insert(*lens);
    }
    for (const auto& [phrase, file] : folder.masks) {
      truth.masks[name].push_back({file, object_of_phrase.at(phrase)});
    }
  }
  return truth;
}

}  // namespace freegs::stages
