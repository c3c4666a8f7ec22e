// SPDX-License-Identifier: BSD-3-Clause

#include "stages/ingest/ingest_masks.h"

#include <cmath>
#include <optional>
#include <set>
#include <system_error>
#include <vector>

#include "core/cancellation.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/number_text.h"
#include "photos/photo_mask.h"
#include "photos/photo_scan.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using photos::Photo;
using pipeline::LogLevel;
using pipeline::StageContext;

constexpr uint64_t kMaxMaskBytes = uint64_t{1} << 30;

// Masks that keep less than this share of their photos are probably inverted.
constexpr double kLittle = 0.05;

// What to do when masks ignore too much.
std::string ExchangeAdvice(const IngestMaskOptions& options) {
  return options.invert_masks
             ? "if black is to be ignored, set ingest.invert_masks to false"
             : "if white is to be ignored, set ingest.invert_masks";
}

// Writes one mask to the workspace and returns the share of pixels that it
// keeps. Returns nothing, after a warning, for a mask that cannot be used.
StatusOr<std::optional<double>> PlaceMask(
    StageContext& context,
    const fs::path& path,
    const IngestMaskOptions& options,
    const photos::PhotoDecodeOptions& decode,
    const Photo& photo) {
  const StatusOr<std::string> bytes = ReadFile(path, kMaxMaskBytes);
  StatusOr<ImageU8> mask = bytes.status();
  if (bytes.ok()) {
    mask = photos::DecodeMask(*bytes, photo, options.invert_masks, decode);
  }
  std::string fault = mask.status().message();
  double kept = 0;
  if (mask.ok()) {
    kept = photos::KeptShare(*mask);
    if (kept == 0) {
      fault = "it ignores the whole photo; remove one of the two, or, " +
              ExchangeAdvice(options);
    }
  }
  if (!fault.empty()) {
    context.log(LogLevel::kWarning,
                path.string() + ": mask not used: " + fault);
    return std::optional<double>();
  }
  const fs::path target =
      context.output / "masks" / fs::path(photo.name + ".png");
  FREEGS_RETURN_IF_ERROR(CreateFolders(target.parent_path()));
  FREEGS_RETURN_IF_ERROR(WriteImage(target, *mask));
  return std::optional<double>(kept);
}

// Gives the other photos a white mask: COLMAP from 3.12 on skips photos without
// a mask if some photos have one.
Status FillWithWhite(const StageContext& context,
                     const photos::PhotoList& list) {
  for (const Photo& photo : list.photos) {
    if (!photo.usable() || photo.has_mask) continue;
    const fs::path target =
        context.output / "masks" / fs::path(photo.name + ".png");
    FREEGS_RETURN_IF_ERROR(CreateFolders(target.parent_path()));
    FREEGS_RETURN_IF_ERROR(
        WriteImage(target, ImageU8(photo.width, photo.height, 1, 255)));
  }
  return Status();
}

// Warns of masks that fit no photo, which are often misnamed.
void WarnOfUnused(const StageContext& context,
                  const fs::path& mask_folder,
                  const std::set<std::string>& used) {
  const StatusOr<photos::PhotoScan> scan = photos::ScanPhotos(mask_folder);
  if (!scan.ok()) return;
  size_t unused = 0;
  std::string example;
  for (const std::string& file : scan->files) {
    if (used.contains(file)) continue;
    if (++unused == 1) example = file;
  }
  if (unused == 0) return;
  context.log(LogLevel::kWarning,
              mask_folder.string() + ": " + std::to_string(unused) +
                  " files fit no photo, or several, such as " + example +
                  "; the mask of a.jpg is a.jpg.png or a.png");
}

}  // namespace

StatusOr<fs::path> FindMaskFolder(const fs::path& images,
                                  const IngestMaskOptions& options) {
  std::error_code error;
  if (!options.use_masks) return fs::path();
  const fs::path folder =
      options.masks.empty() ? images / "masks" : fs::path(options.masks);
  if (!fs::is_directory(folder, error)) {
    if (options.masks.empty()) return fs::path();
    return BadInputError(options.masks +
                         ": no such folder of masks (ingest.masks)");
  }
  // No photo would be left: photos are not looked for among masks.
  if (fs::equivalent(folder, images, error)) {
    return BadInputError(folder.string() +
                         ": the photos lie in this folder; put the masks into "
                         "a folder of their own (ingest.masks)");
  }
  return folder;
}

Status PlaceMasks(StageContext& context,
                  const fs::path& mask_folder,
                  const IngestMaskOptions& options,
                  const photos::PhotoDecodeOptions& decode,
                  photos::PhotoList* list) {
  std::error_code ignored;
  fs::remove_all(context.output / "masks", ignored);
  if (mask_folder.empty()) return Status();
  size_t masks = 0;
  double kept = 0;
  std::set<std::string> used;
  size_t usable = 0;
  std::set<std::string> pictures;
  for (const Photo& photo : list->photos) {
    if (!photo.usable()) continue;
    ++usable;
    pictures.insert(photo.hash);
  }
  // A mask that could be meant for a photo that was dropped goes to no other.
  std::vector<Photo*> candidates;
  std::vector<std::string> candidate_files;
  for (Photo& photo : list->photos) {
    const bool decoded = !photo.hash.empty();
    if (photo.usable() || (decoded && pictures.insert(photo.hash).second)) {
      candidates.push_back(&photo);
      candidate_files.push_back(photo.file);
      continue;
    }
    // What cannot be read, or is there twice, takes no mask from a photo.
    if (auto file = photos::FindMasks(mask_folder, {photo.file}).front()) {
      used.insert(*std::move(file));
    }
  }
  const std::vector<std::optional<std::string>> mask_files =
      photos::FindMasks(mask_folder, candidate_files);
  for (size_t i = 0; i < candidates.size(); ++i) {
    Photo& photo = *candidates[i];
    const std::optional<std::string>& file = mask_files[i];
    if (!file) continue;
    used.insert(*file);
    if (!photo.usable()) continue;
    if (IsCancelled(context.cancellation)) {
      return InterruptedError("stopped while reading masks");
    }
    FREEGS_ASSIGN_OR_RETURN(
        const std::optional<double> share,
        PlaceMask(context, mask_folder / *file, options, decode, photo));
    photo.has_mask = share.has_value();
    if (!share) continue;
    ++masks;
    kept += *share;
  }
  WarnOfUnused(context, mask_folder, used);
  if (masks > 0) FREEGS_RETURN_IF_ERROR(FillWithWhite(context, *list));
  const double mean = masks > 0 ? kept / static_cast<double>(masks) : 1;
  context.summary["masks"] = masks;
  context.summary["mask_kept_share"] = mean;
  const std::string percent = FormatPercent(mean);
  context.log(
      masks < usable ? LogLevel::kWarning : LogLevel::kInfo,
      std::to_string(masks) + " of " + std::to_string(usable) +
          " photos have a mask" +
          (masks > 0 ? "; they keep " + percent + " of the pixels" : ""));
  if (masks > 0 && mean < kLittle) {
    context.log(LogLevel::kWarning,
                "the masks leave only " + percent + " of the pixels; " +
                    ExchangeAdvice(options));
  }
  return Status();
}

}  // namespace freegs::stages
