// SPDX-License-Identifier: BSD-3-Clause

#include "stages/film/rendered_frames.h"

#include <algorithm>
#include <set>
#include <system_error>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_fields.h"
#include "core/io/json_text.h"
#include "stages/film/film_views.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

struct FrameCounts {
  size_t frames = 0;
  size_t previews = 0;
};

fs::path FrameListPath(const fs::path& folder) {
  return folder / "rendered_frames.json";
}

FrameCounts ReadFrameCounts(const fs::path& folder) {
  constexpr int kMaxFrames = 1'000'000;
  const StatusOr<nlohmann::json> list = ReadJson(FrameListPath(folder));
  if (!list.ok()) return {};
  const auto count = [&list](const char* key) {
    const StatusOr<int> number =
        ReadInteger(FindField(*list, key), 0, kMaxFrames, key);
    return number.ok() ? static_cast<size_t>(*number) : size_t{0};
  };
  return {count("frames"), count("previews")};
}

Status WriteFrameCounts(const fs::path& folder, const FrameCounts& counts) {
  return WriteFileAtomic(
      FrameListPath(folder),
      JsonText({{"frames", counts.frames}, {"previews", counts.previews}}));
}

// Removes the frames from number `begin` to `end`, counted from 0, and returns
// how many there were.
size_t RemoveFrames(const fs::path& folder, size_t begin, size_t end) {
  size_t removed = 0;
  for (size_t frame = begin; frame < end; ++frame) {
    std::error_code error;
    if (fs::remove(folder / FrameName(frame), error)) ++removed;
  }
  return removed;
}

}  // namespace

Status ForgetReplacedFrames(const fs::path& folder,
                            const std::vector<std::string>& names,
                            bool previews) {
  const FrameCounts earlier = ReadFrameCounts(folder);
  const std::set<std::string> replaced(names.begin(), names.end());
  const size_t most = std::max(earlier.frames, earlier.previews);
  size_t kept = 0;
  while (kept < most && !replaced.contains(FrameName(kept))) ++kept;
  if (kept == most) return Status();
  return WriteFrameCounts(
      folder,
      {std::min(kept, earlier.frames),
       previews ? std::min(kept, earlier.previews) : earlier.previews});
}

StatusOr<std::string> RemoveLaterFrames(const fs::path& folder,
                                        size_t count,
                                        bool previews) {
  const FrameCounts earlier = ReadFrameCounts(folder);
  RemoveFrames(folder / "preview", count, earlier.previews);
  const size_t removed = RemoveFrames(folder, count, earlier.frames);
  // The new list is written after that, so that nothing is forgotten in
  // between.
  FREEGS_RETURN_IF_ERROR(WriteFrameCounts(
      folder, {count, previews ? count : std::min(count, earlier.previews)}));
  std::string told;
  if (removed > 0) {
    told +=
        std::to_string(removed) + " pictures of a longer path were removed\n";
  }
  std::error_code error;
  const std::string next = FrameName(std::max(count, earlier.frames));
  if (fs::exists(folder / next, error)) {
    told += next + " and later frames stay: " +
            FrameListPath(folder).filename().string() +
            " does not say that an earlier path wrote them\n";
  }
  return told;
}

}  // namespace freegs::stages
