// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_selection.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fnmatch.h>
#include <map>
#include <sstream>
#include <tuple>

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

// Photos named by the rule; what names nothing is added to `unmatched`.
void HoldOutNamed(const std::vector<std::string>& names,
                  const std::vector<Photo*>& photos,
                  std::vector<std::string>* unmatched) {
  for (const std::string& name : names) {
    bool found = false;
    for (Photo* photo : photos) {
      if (photo->file != name && BaseName(photo->file) != name) continue;
      photo->split = PhotoSplit::kHoldout;
      found = true;
    }
    if (!found) unmatched->push_back(name);
  }
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
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.ends_with('\r')) line.pop_back();
    if (!line.empty() && line.front() != '#') names.push_back(line);
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
    HoldOutNamed(rule.names, usable, &unmatched);
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
  std::map<std::tuple<bool,
                      int,
                      int,
                      std::string,
                      std::string,
                      std::optional<double>,
                      std::optional<double>>,
           int>
      groups;
  for (Photo* photo : Usable(photos)) {
    const auto [group, fresh] = groups.try_emplace({photo->film.empty(),
                                                    photo->width,
                                                    photo->height,
                                                    photo->make,
                                                    photo->model,
                                                    photo->focal_length_mm,
                                                    photo->focal_length_35mm},
                                                   groups.size());
    photo->camera_group = group->second;
  }
}

}  // namespace freegs::photos
