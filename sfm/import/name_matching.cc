// SPDX-License-Identifier: BSD-3-Clause
// Names to photos.

#include "sfm/import/name_matching.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <unordered_map>
#include <utility>

namespace freegs::sfm {
namespace {

struct PathParts {
  std::vector<std::string> folders;  // Innermost first.
  std::string stem;
  std::string extension;
};

PathParts Split(std::string_view path) {
  std::vector<std::string> parts;
  size_t start = 0;
  while (start <= path.size()) {
    const size_t end = std::min(path.find_first_of("/\\", start), path.size());
    const std::string_view part = path.substr(start, end - start);
    if (!part.empty() && part != ".") parts.emplace_back(part);
    start = end + 1;
  }
  PathParts result;
  if (parts.empty()) return result;
  result.stem = parts.back();
  parts.pop_back();
  // Only what looks like an extension: "r_0.5" keeps its ".5" by comparing
  // stems with and without it (see Score).
  const size_t dot = result.stem.rfind('.');
  if (dot != std::string::npos && dot > 0) {
    result.extension = result.stem.substr(dot);
    result.stem.resize(dot);
  }
  result.folders.assign(parts.rbegin(), parts.rend());
  return result;
}

// The innermost folders of paths.
std::set<std::string> InnermostFolders(const std::vector<PathParts>& paths) {
  std::set<std::string> folders;
  for (const PathParts& path : paths) {
    if (!path.folders.empty()) folders.insert(path.folders.front());
  }
  return folders;
}

// How well two paths fit; 0 is not at all.
int Score(const PathParts& name, const PathParts& photo) {
  const bool same_file = name.stem == photo.stem;
  // A name without extension may contain a dot itself.
  const bool bare = name.stem + name.extension == photo.stem;
  if (name.stem.empty() || (!same_file && !bare)) return 0;
  int score = 4;
  if (same_file && name.extension == photo.extension) score += 2;
  const size_t depth = std::min(name.folders.size(), photo.folders.size());
  size_t shared = 0;
  while (shared < depth && name.folders[shared] == photo.folders[shared]) {
    ++shared;
  }
  score += 8 * static_cast<int>(shared);
  // The paths agree from their beginning, not only from their end.
  if (name.folders == photo.folders) score += 4;
  // images/0001.jpg fits the photo 0001.jpg better than sub/0001.jpg, of which
  // a folder is missing. This decides only where nothing else does.
  if (shared == photo.folders.size()) score += 1;
  return score;
}

// Whether the name has the folder right above the photo's own path.
bool LiesIn(const std::string& folder,
            const PathParts& name,
            const PathParts& photo) {
  const size_t depth = photo.folders.size();
  return !folder.empty() && name.folders.size() > depth &&
         name.folders[depth] == folder;
}

// The paths of photos, by the names of their files.
class PhotoPaths {
 public:
  PhotoPaths(const std::vector<SfmPhoto>& photos,
             std::set<std::string> folders_of_names)
      : folders_of_names_(std::move(folders_of_names)) {
    for (size_t i = 0; i < photos.size(); ++i) {
      std::vector<std::string> paths = {photos[i].name};
      if (!photos[i].file.empty() && photos[i].file != photos[i].name) {
        paths.push_back(photos[i].file);
      }
      for (const std::string& path : paths) {
        parts_.push_back(Split(path));
        photo_of_part_.push_back(static_cast<int>(i));
        by_stem_.emplace(parts_.back().stem, parts_.size() - 1);
      }
    }
    folders_of_photos_ = InnermostFolders(parts_);
  }

  struct Fit {
    int photo = -1;
    int score = 0;
    const PathParts* path = nullptr;  // That of the photo which fits.
  };

  // The photo that fits the name best. Without one, or if two fit as well, its
  // number is -1.
  Fit Best(const PathParts& name) const {
    Fit best;
    bool ambiguous = false;
    for (const std::string& stem : {name.stem, name.stem + name.extension}) {
      const auto [first, last] = by_stem_.equal_range(stem);
      for (auto it = first; it != last; ++it) {
        const PathParts& path = parts_[it->second];
        const int photo = photo_of_part_[it->second];
        if (Contradict(name, path)) continue;
        const int score = Score(name, path);
        if (score > best.score) {
          ambiguous = false;
          best = {photo, score, &path};
        } else if (score == best.score && photo != best.photo) {
          ambiguous = true;
        }
      }
    }
    return ambiguous ? Fit() : best;
  }

 private:
  // left/1.jpg is not right/1.jpg where both sides know such folders, also when
  // one of the two photos is missing.
  bool Contradict(const PathParts& name, const PathParts& photo) const {
    return !name.folders.empty() && !photo.folders.empty() &&
           name.folders.front() != photo.folders.front() &&
           (folders_of_photos_.contains(name.folders.front()) ||
            folders_of_names_.contains(photo.folders.front()));
  }

  std::vector<PathParts> parts_;
  std::vector<int> photo_of_part_;
  std::unordered_multimap<std::string, size_t> by_stem_;
  std::set<std::string> folders_of_names_;
  std::set<std::string> folders_of_photos_;
};

}  // namespace

NameMatches MatchNames(const std::vector<std::string>& names,
                       const std::vector<SfmPhoto>& photos,
                       const std::string& folder) {
  std::vector<PathParts> name_parts;
  for (const std::string& name : names) name_parts.push_back(Split(name));
  const PhotoPaths paths(photos, InnermostFolders(name_parts));

  struct Claim {
    int name = -1;
    std::pair<int, bool> score;  // And whether it lies in the folder.
    int other = -1;              // The first name that is as good.
  };
  std::vector<Claim> claims(photos.size());
  for (size_t n = 0; n < names.size(); ++n) {
    const PathParts& parts = name_parts[n];
    const PhotoPaths::Fit best = paths.Best(parts);
    if (best.photo < 0) continue;
    Claim& claim = claims[best.photo];
    const std::pair score(best.score, LiesIn(folder, parts, *best.path));
    if (score > claim.score) {
      claim = {static_cast<int>(n), score};
    } else if (score == claim.score && claim.other < 0) {
      claim.other = static_cast<int>(n);
    }
  }

  NameMatches result;
  result.photos.assign(names.size(), -1);
  for (size_t i = 0; i < photos.size(); ++i) {
    const Claim& claim = claims[i];
    const int photo = static_cast<int>(i);
    if (claim.name >= 0) result.photos[claim.name] = photo;
    if (claim.other >= 0) {
      result.ties.push_back({photo, claim.name, claim.other});
    }
  }
  return result;
}

}  // namespace freegs::sfm
