// SPDX-License-Identifier: BSD-3-Clause
// Parses COLMAP's output lines.

#include "sfm/colmap/colmap_output.h"

#include <charconv>

namespace freegs::sfm {
namespace {

// Removes `text` and everything before it; false when it is not there.
bool SkipPast(std::string_view text, std::string_view* line) {
  const size_t at = line->find(text);
  if (at == std::string_view::npos) return false;
  line->remove_prefix(at + text.size());
  return true;
}

bool TakeNumber(std::string_view* line, int* number) {
  const auto result =
      std::from_chars(line->data(), line->data() + line->size(), *number);
  if (result.ec != std::errc() || *number < 0) return false;
  line->remove_prefix(result.ptr - line->data());
  return true;
}

// "3/50]" and the like.
std::optional<ColmapProgress> ParseFraction(ColmapProgress::Kind kind,
                                            std::string_view line) {
  ColmapProgress progress;
  progress.kind = kind;
  if (!TakeNumber(&line, &progress.done) || !SkipPast("/", &line) ||
      !TakeNumber(&line, &progress.total)) {
    return {};
  }
  return progress;
}

// "7 (12)"; newer releases write "7 (num_reg_frames=12)".
std::optional<ColmapProgress> ParseCount(ColmapProgress::Kind kind,
                                         std::string_view line) {
  ColmapProgress progress;
  progress.kind = kind;
  if (!SkipPast("(", &line)) return {};
  SkipPast("=", &line);
  if (!TakeNumber(&line, &progress.done)) return {};
  return progress;
}

}  // namespace

std::optional<ColmapProgress> ParseColmapLine(std::string_view line) {
  using Kind = ColmapProgress::Kind;
  std::string_view rest = line;
  if (SkipPast("Undistorting image [", &rest)) {
    return ParseFraction(Kind::kPhotoUndistorted, rest);
  }
  if (SkipPast("Registering image #", &rest)) {
    return ParseCount(Kind::kPhotoRegistered, rest);
  }
  if (SkipPast("Triangulating image #", &rest)) {
    return ParseCount(Kind::kPhotoTriangulated, rest);
  }
  if (SkipPast("Global bundle adjustment", &rest)) {
    return ColmapProgress{.kind = Kind::kAdjusting};
  }
  return {};
}

}  // namespace freegs::sfm
