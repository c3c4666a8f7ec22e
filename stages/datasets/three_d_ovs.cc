// SPDX-License-Identifier: BSD-3-Clause

#include "stages/datasets/three_d_ovs.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/io/files.h"
#include "core/text.h"
#include "stages/datasets/mask_folders.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxListBytes = uint64_t{1} << 20;

// The form in which class names are compared.
std::string Folded(std::string text) {
  for (char& c : text) {
    c = c == '_'
            ? ' '
            : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return text;
}

// The form in which photograph names are compared: without leading zeros.
std::string WithoutLeadingZeros(const std::string& name) {
  const bool number =
      !name.empty() && std::all_of(name.begin(), name.end(), IsDigit);
  if (!number) return name;
  return name.substr(std::min(name.find_first_not_of('0'), name.size() - 1));
}

// The classes of classes.txt by the form in which they are compared. Empty
// without that file.
StatusOr<std::map<std::string, std::string>> ReadClasses(const fs::path& path) {
  std::map<std::string, std::string> classes;
  std::error_code error;
  if (!fs::exists(path, error)) return classes;
  FREEGS_ASSIGN_OR_RETURN(const std::string text,
                          ReadFile(path, kMaxListBytes));
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::string name(Trimmed(line));
    if (!name.empty()) classes[Folded(name)] = name;
  }
  return classes;
}

}  // namespace

StatusOr<GroundTruth> ReadThreeDOvs(const fs::path& scene) {
  const fs::path root = scene / "segmentations";
  FREEGS_ASSIGN_OR_RETURN(std::vector<MaskFolder> folders,
                          ListMaskFolders(root));
  FREEGS_ASSIGN_OR_RETURN(const auto classes,
                          ReadClasses(root / "classes.txt"));
  FREEGS_ASSIGN_OR_RETURN(const DatasetPhotos photos, ReadDatasetPhotos(scene));
  std::map<std::string, std::vector<size_t>> photos_by_name;
  for (size_t i = 0; i < photos.names.size(); ++i) {
    photos_by_name[WithoutLeadingZeros(PhotoStem(photos.names[i]))].push_back(
        i);
  }
  std::vector<std::pair<size_t, MaskFolder>> views;
  std::set<size_t> used;
  for (MaskFolder& folder : folders) {
    const auto found = photos_by_name.find(WithoutLeadingZeros(folder.name));
    if (found == photos_by_name.end() || found->second.size() > 1) {
      return BadInputError((root / folder.name).string() +
                           (found == photos_by_name.end()
                                ? ": no photograph has this name"
                                : ": several photographs have this "
                                  "name"));
    }
    if (!used.insert(found->second[0]).second) {
      return BadInputError((root / folder.name).string() +
                           ": a second folder of masks for " +
                           photos.names[found->second[0]]);
    }
    for (auto& [phrase, file] : folder.masks) {
      const auto known = classes.find(Folded(phrase));
      if (known != classes.end()) phrase = known->second;
    }
    views.emplace_back(found->second[0], std::move(folder));
  }
  return TruthOfMasks(scene, photos, views);
}

}  // namespace freegs::stages
