// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_selection.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fnmatch.h>
#include <map>
#include <sstream>
#include <string_view>
#include <tuple>

#include "core/text.h"

namespace freegs::photos {
namespace {

constexpr int64_t kMinKept = 3;
constexpr int kMinTraining = 2;

std::vector<Photo*> Usable(std::vector<Photo>* photos) {
  std::vector<Photo*> usable;
  for (Photo& photo : *photos) {
    if (photo.usable()) usable.push_back(&photo);
  }
  return usable;
}

void Reject(Photo* photo, std::string reason) {
  photo->split = PhotoSplit::kRejected;
  photo->reason = std::move(reason);
}

std::string BaseName(const std::string& file) {
  return std::filesystem::path(file).filename().string();
}

bool Matches(const std::string& pattern, const std::string& file) {
  return fnmatch(pattern.c_str(), file.c_str(), 0) == 0 ||
         fnmatch(pattern.c_str(), BaseName(file).c_str(), 0) == 0;
}

// A name without white space around it and without "./" in front, which some
// programs write.
std::string PlainName(std::string_view name) {
  name = Trimmed(name);
  while (name.starts_with("./")) name.remove_prefix(2);
  return std::string(name);
}

std::string WithoutSuffix(const std::string& file) {
  return std::filesystem::path(file).replace_extension().string();
}

// Finds the photos that a plain name means, the rejected ones too. Whole names
// go before those without folders, the files' own names before those in the
// workspace, and these before the files' names without suffix.
class PhotoFinder {
 public:
  explicit PhotoFinder(std::vector<Photo>* photos) {
    for (Photo& photo : *photos) {
      Add(photo.file, &photo, &by_whole_file_, &by_file_);
      Add(photo.name, &photo, &by_whole_name_, &by_name_);
      Add(WithoutSuffix(photo.file), &photo, &by_stem_, &by_stem_);
    }
  }

  std::vector<Photo*> Find(const std::string& name) const {
    for (const PhotosByName* known :
         {&by_whole_file_, &by_whole_name_, &by_file_, &by_name_}) {
      const auto found = known->find(name);
      if (found != known->end()) return found->second;
    }
    const auto found = by_stem_.find(name);
    if (found == by_stem_.end()) return {};
    std::vector<Photo*> photos = found->second;
    if (photos.size() > 1) {
      std::erase_if(photos,
                    [](const Photo* photo) { return !photo->usable(); });
    }
    // If there are several, nobody knows which of them is meant.
    return photos.size() == 1 ? photos : std::vector<Photo*>();
  }

 private:
  using PhotosByName = std::map<std::string, std::vector<Photo*>>;

  static void Add(const std::string& file,
                  Photo* photo,
                  PhotosByName* by_whole,
                  PhotosByName* by_base) {
    if (file.empty()) return;
    const std::string whole = PlainName(file);
    const std::string base = PlainName(BaseName(file));
    (*by_whole)[whole].push_back(photo);
    if (base != whole) (*by_base)[base].push_back(photo);
  }

  PhotosByName by_whole_file_;
  PhotosByName by_whole_name_;
  PhotosByName by_file_;
  PhotosByName by_name_;
  PhotosByName by_stem_;
};

// Holds out the photos named by the rule; what names no usable photo is added
// to `unmatched`. kBadInput if no name means a photo.
Status HoldOutNamed(const std::vector<std::string>& names,
                    std::vector<Photo>* photos,
                    std::vector<std::string>* unmatched) {
  const PhotoFinder finder(photos);
  bool any = false;
  for (const std::string& name : names) {
    bool usable = false;
    for (Photo* photo : finder.Find(PlainName(name))) {
      any = true;
      if (!photo->usable()) continue;
      photo->split = PhotoSplit::kHoldout;
      usable = true;
    }
    if (!usable) unmatched->push_back(name);
  }
  if (any) return Status();
  return BadInputError(
      "no photo is named like any line of the list of holdout photos: " +
      SomeNames(names, 3) +
      "; write their names as they are in the photo folder, one per line");
}

// Fewer photos than these do not tell a lens well enough to have their own.
constexpr int kMinOfSource = 10;

// What tells cameras apart where EXIF does not: the film of a frame, and the
// folder of a photo whose EXIF knows no camera. Empty for other photos.
std::string SourceOf(const Photo& photo) {
  if (!photo.film.empty()) return photo.film;
  const bool known = !photo.make.empty() || !photo.model.empty() ||
                     photo.focal_length_mm || photo.focal_length_35mm;
  if (known) return "";
  return std::filesystem::path(photo.file).parent_path().string();
}

}  // namespace

void RejectDuplicates(std::vector<Photo>* photos) {
  const std::vector<Photo*> usable = Usable(photos);
  std::map<std::string, const Photo*> kept;
  for (const Photo* photo : usable) {
    const Photo*& best = kept.try_emplace(photo->hash, photo).first->second;
    if (std::tuple(photo->file.size(), photo->file) <
        std::tuple(best->file.size(), best->file)) {
      best = photo;
    }
  }
  for (Photo* photo : usable) {
    const Photo* same = kept[photo->hash];
    if (photo != same) {
      Reject(photo, "duplicate of " + same->file + ": the same picture");
    }
  }
}

void RejectBlurred(double fraction, std::vector<Photo>* photos) {
  const std::vector<Photo*> usable = Usable(photos);
  const int64_t count = static_cast<int64_t>(usable.size());
  const int64_t kept =
      std::clamp<int64_t>(std::llround(fraction * static_cast<double>(count)),
                          std::min(kMinKept, count),
                          count);
  if (kept == count) return;
  const bool keep_one = 2 * kept <= count;
  const int64_t windows = keep_one ? kept : count - kept;
  for (int64_t window = 0; window < windows; ++window) {
    const auto first = usable.begin() + window * count / windows;
    const auto last = usable.begin() + (window + 1) * count / windows;
    const auto blurrier = [](const Photo* a, const Photo* b) {
      return a->sharpness < b->sharpness;
    };
    const auto chosen = keep_one ? std::max_element(first, last, blurrier)
                                 : std::min_element(first, last, blurrier);
    for (auto photo = first; photo != last; ++photo) {
      if ((photo == chosen) != keep_one) {
        Reject(*photo, "blurrier than its neighbours");
      }
    }
  }
}

Status HoldoutRule::Check() const {
  if (every < 0) {
    return InvalidArgumentError("holdout_every must not be negative");
  }
  return Status();
}

std::vector<std::string> ParseNameList(const std::string& text) {
  std::vector<std::string> names;
  std::istringstream lines{std::string(WithoutByteOrderMark(text))};
  for (std::string line; std::getline(lines, line);) {
    const std::string name = PlainName(line);
    if (!name.empty() && name.front() != '#') names.push_back(name);
  }
  return names;
}

StatusOr<std::vector<std::string>> AssignHoldout(const HoldoutRule& rule,
                                                 std::vector<Photo>* photos) {
  const std::vector<Photo*> usable = Usable(photos);
  for (Photo* photo : usable) photo->split = PhotoSplit::kTrain;
  std::vector<std::string> unmatched;
  int held = 0;
  if (!rule.names.empty()) {
    FREEGS_RETURN_IF_ERROR(HoldOutNamed(rule.names, photos, &unmatched));
  } else if (rule.pattern == "none") {
    // All for training.
  } else if (!rule.pattern.empty()) {
    for (Photo* photo : usable) {
      if (!Matches(rule.pattern, photo->file)) continue;
      photo->split = PhotoSplit::kHoldout;
      ++held;
    }
    if (held == 0) unmatched.push_back(rule.pattern);
  } else if (rule.every > 0) {
    for (size_t i = 0; i < usable.size(); i += rule.every) {
      usable[i]->split = PhotoSplit::kHoldout;
    }
  }
  const auto training =
      std::count_if(usable.begin(), usable.end(), [](const Photo* photo) {
        return photo->split == PhotoSplit::kTrain;
      });
  if (training < kMinTraining) {
    return BadInputError(
        "only " + std::to_string(training) + " of " +
        std::to_string(usable.size()) +
        " usable photos are left for training; hold out fewer of them");
  }
  return unmatched;
}

void AssignCameraGroups(std::vector<Photo>* photos) {
  std::map<std::string, int> photos_of_source;
  for (const Photo* photo : Usable(photos)) {
    ++photos_of_source[SourceOf(*photo)];
  }
  std::map<std::tuple<bool,
                      std::string,
                      int,
                      int,
                      std::string,
                      std::string,
                      std::optional<double>,
                      std::optional<double>,
                      double>,
           int>
      groups;
  for (Photo* photo : Usable(photos)) {
    std::string source = SourceOf(*photo);
    if (photos_of_source[source] < kMinOfSource) source.clear();
    const auto [group, fresh] = groups.try_emplace({photo->film.empty(),
                                                    source,
                                                    photo->width,
                                                    photo->height,
                                                    photo->make,
                                                    photo->model,
                                                    photo->focal_length_mm,
                                                    photo->focal_length_35mm,
                                                    photo->digital_zoom},
                                                   groups.size());
    photo->camera_group = group->second;
  }
}

}  // namespace freegs::photos
