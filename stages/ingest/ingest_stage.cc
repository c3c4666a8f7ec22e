// SPDX-License-Identifier: BSD-3-Clause

#include "stages/ingest/ingest_stage.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/cancellation.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "photos/photo_decode.h"
#include "photos/photo_list.h"
#include "photos/photo_names.h"
#include "photos/photo_scan.h"
#include "photos/photo_selection.h"
#include "stages/ingest/ingest_films.h"
#include "stages/ingest/ingest_forecast.h"
#include "stages/ingest/ingest_holdout.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using photos::Photo;
using photos::PhotoSplit;
using pipeline::LogLevel;
using pipeline::StageContext;

constexpr int kMinUsable = 3;

// The name of a file, safe to print within one line.
std::string OneLine(std::string name) {
  for (char& c : name) {
    if (static_cast<uint8_t>(c) < 0x20 || c == 0x7f) c = '?';
  }
  return name;
}

// Calls body(i) for 0 <= i < count on all threads, reports progress, and
// returns the error of the smallest i that has one. kInterrupted when
// cancelled.
Status ForEachPhoto(StageContext& context,
                    const std::string& step,
                    size_t count,
                    const std::function<Status(size_t)>& body) {
  std::vector<Status> results(count);
  std::atomic<int64_t> done = 0;
  context.pool->ParallelFor(
      0,
      static_cast<int64_t>(count),
      1,
      [&](int64_t first, int64_t last, int worker) {
        for (int64_t i = first; i < last; ++i) {
          if (IsCancelled(context.cancellation)) return;
          results[i] = body(static_cast<size_t>(i));
          ++done;
          // Only the calling thread reports, so that receivers need no locks.
          if (worker == 0) {
            context.progress({step,
                              static_cast<double>(done.load()),
                              static_cast<double>(count),
                              ""});
          }
        }
      });
  if (IsCancelled(context.cancellation)) {
    return InterruptedError("stopped while " + step);
  }
  for (const Status& result : results) FREEGS_RETURN_IF_ERROR(result);
  return Status();
}

// The content of a linked folder is an input, so it must not hold what a run
// writes, nor be part of it. Of the photo folder itself the commands see to
// that.
Status CheckLinkedFolders(const StageContext& context,
                          const photos::PhotoScan& scan) {
  for (const std::string& link : scan.linked_folders) {
    std::error_code error;
    const fs::path target = fs::canonical(context.images / link, error);
    if (error) continue;
    const bool holds = IsWithin(context.workspace, target);
    if (!holds && !IsWithin(target, context.workspace)) continue;
    return BadInputError(
        OneLine((context.images / link).string()) + ": this link leads to " +
        OneLine(target.string()) + ", which " +
        (holds ? "holds the workspace" : "lies in the workspace") +
        ", so each run would find changed photos. Delete the link, or give a "
        "workspace elsewhere");
  }
  return Status();
}

class IngestStage : public pipeline::Stage {
 public:
  explicit IngestStage(const IngestStageOptions& options) : options_(options) {}

  std::string_view name() const override { return "ingest"; }
  int version() const override { return 5; }

  std::vector<fs::path> Inputs(const StageContext& context) const override {
    std::vector<fs::path> inputs = {context.images};
    if (!options_.holdout_list.empty()) {
      inputs.emplace_back(options_.holdout_list);
    }
    // A folder's hash does not follow links to folders; the scan does.
    if (!options_.masks.masks.empty() && options_.masks.use_masks) {
      inputs.emplace_back(options_.masks.masks);
    }
    const auto scan = Scan(context);
    if (!scan.ok()) return inputs;
    for (const std::string& link : scan->linked_folders) {
      inputs.push_back(context.images / link / "");
    }
    for (fs::path& link : LinkedMasks(context)) {
      inputs.push_back(std::move(link));
    }
    return inputs;
  }

  // Nothing is known of films before frames are taken from them.
  pipeline::StageNeed Foretell(const StageContext& context,
                               bool done,
                               pipeline::SceneOutlook* scene) const override {
    if (done) {
      const fs::path folder = context.workspace / "ingest";
      const auto list = photos::ReadPhotoList(folder / "images.json");
      if (list.ok()) AddPhotosTo(list->photos, folder / "photos", scene);
    } else {
      const auto scan = Scan(context);
      if (!scan.ok()) return {.unknown_reason = scan.status().message()};
      if (scan->files.empty() && !scan->films.empty()) {
        return {.unknown_reason =
                    "of a film nothing is known before its frames are "
                    "taken (stage ingest)"};
      }
      std::vector<Photo> photos =
          ReadPhotoHeaders(context.images, scan->files, options_.decode);
      photos::RejectBlurred(options_.keep_sharpest, &photos);
      const auto rule = ReadHoldoutRule();
      if (rule.ok()) (void)photos::AssignHoldout(*rule, &photos);
      AddPhotosTo(photos, context.images, scene);
      const auto masks = FindMaskFolder(context.images, options_.masks);
      scene->masks = masks.ok() && !masks->empty();
    }
    return IngestNeed(*scene, context.pool->num_threads());
  }

  Status Run(StageContext& context) override {
    FREEGS_RETURN_IF_ERROR(options_.Check());
    if (context.images.empty()) {
      return BadInputError(
          "no photo folder was given; name it once: freegs_pipeline run IMAGES "
          "WORKSPACE");
    }
    FREEGS_ASSIGN_OR_RETURN(photos::HoldoutRule rule, ReadHoldoutRule());
    FREEGS_RETURN_IF_ERROR(PrepareFolders(context));
    photos::PhotoList list;
    // Later stages hash the list, so that equal photos are the same to them
    // from each folder of this name. Stage sfm compares the name with the paths
    // in an imported file. The full path is in workspace.json.
    list.images_folder = context.images.has_filename()
                             ? context.images.filename().string()
                             : context.images.parent_path().filename().string();
    FREEGS_RETURN_IF_ERROR(Inspect(context, &list));
    FREEGS_RETURN_IF_ERROR(Select(context, rule, &list));
    FREEGS_RETURN_IF_ERROR(PlacePhotos(context, list));
    FREEGS_ASSIGN_OR_RETURN(const fs::path masks,
                            FindMaskFolder(context.images, options_.masks));
    FREEGS_RETURN_IF_ERROR(
        PlaceMasks(context, masks, options_.masks, options_.decode, &list));
    FREEGS_RETURN_IF_ERROR(
        WritePhotoList(context.output / "images.json", list));
    Summarise(list, &context.summary);
    return Status();
  }

 private:
  // The folders of masks that the hash of the photo folder and that of the
  // folder of masks leave out, because they are links. Nothing without links,
  // so that the inputs of finished workspaces stay the same.
  std::vector<fs::path> LinkedMasks(const StageContext& context) const {
    std::vector<fs::path> links;
    const auto masks = FindMaskFolder(context.images, options_.masks);
    if (!masks.ok() || masks->empty()) return links;
    std::error_code error;
    // One that the options name is an input of its own, which is followed.
    if (options_.masks.masks.empty() && fs::is_symlink(*masks, error)) {
      links.push_back(*masks / "");
    }
    const auto scan =
        photos::ScanPhotos(*masks, {context.images, context.workspace});
    if (!scan.ok()) return links;
    for (const std::string& link : scan->linked_folders) {
      links.push_back(*masks / link / "");
    }
    return links;
  }

  StatusOr<photos::HoldoutRule> ReadHoldoutRule() const {
    photos::HoldoutRule rule;
    rule.every = options_.holdout_every;
    rule.pattern = options_.holdout;
    if (options_.holdout_list.empty()) return rule;
    constexpr uint64_t kMaxListBytes = uint64_t{64} << 20;
    const StatusOr<std::string> text =
        ReadFile(options_.holdout_list, kMaxListBytes);
    if (!text.ok()) return text.status().Annotated("ingest.holdout_list");
    rule.names = photos::ParseNameList(*text);
    // An empty list means that no photo is kept from training.
    if (rule.names.empty()) rule.pattern = "none";
    return rule;
  }

  // Re-encoded photos wait in pending/ until it is known which of them stay and
  // under which name. Nothing of an interrupted run is used: the stage is
  // short.
  static Status PrepareFolders(const StageContext& context) {
    for (const char* name : {"photos", "pending", "frames"}) {
      std::error_code error;
      fs::remove_all(context.output / name, error);
      FREEGS_RETURN_IF_ERROR(CreateFolders(context.output / name));
    }
    return Status();
  }

  static fs::path PendingPath(const StageContext& context, size_t index) {
    return context.output / "pending" / (std::to_string(index) + ".png");
  }

  // A film that is given by itself is treated as a folder with one film.
  StatusOr<photos::PhotoScan> Scan(const StageContext& context) const {
    std::error_code error;
    if (fs::is_regular_file(context.images, error)) {
      photos::PhotoScan scan;
      scan.films.push_back(context.images.filename().string());
      return scan;
    }
    FREEGS_ASSIGN_OR_RETURN(const fs::path masks,
                            FindMaskFolder(context.images, options_.masks));
    std::vector<fs::path> excluded = {context.workspace};
    if (!masks.empty()) excluded.push_back(masks);
    // Masks are not photos, even if those of another folder are used. A link
    // that leads back to the photos excludes nothing.
    const fs::path beside = context.images / "masks";
    if (options_.masks.use_masks &&
        !fs::equivalent(beside, context.images, error)) {
      excluded.push_back(beside);
    }
    FREEGS_ASSIGN_OR_RETURN(photos::PhotoScan scan,
                            photos::ScanPhotos(context.images, excluded));
    FREEGS_RETURN_IF_ERROR(CheckLinkedFolders(context, scan));
    return scan;
  }

  // The folder of the original photo. Frames of films lie in the workspace.
  static fs::path SourceFolder(const StageContext& context,
                               const Photo& photo) {
    return photo.film.empty() ? context.images : context.output / "frames";
  }

  // Takes frames from films, but only when there are no photos: phones leave a
  // short film beside each photo.
  StatusOr<std::vector<Photo>> TakeFilms(const StageContext& context,
                                         const photos::PhotoScan& scan) const {
    if (scan.films.empty()) return std::vector<Photo>();
    if (!scan.files.empty()) {
      Warn(context,
           std::to_string(scan.films.size()) +
               " films among the photos are not used, such as " +
               OneLine(scan.films.front()) +
               "; give a film, or a folder with films only");
      return std::vector<Photo>();
    }
    std::error_code error;
    photos::VideoFrameOptions film = options_.film;
    film.max_megapixels = options_.decode.max_megapixels;
    film.max_megapixels_option = options_.decode.max_megapixels_option;
    return TakeFilmFrames(context,
                          fs::is_regular_file(context.images, error)
                              ? context.images.parent_path()
                              : context.images,
                          scan.films,
                          film,
                          context.output / "frames");
  }

  Status Inspect(StageContext& context, photos::PhotoList* list) const {
    FREEGS_ASSIGN_OR_RETURN(const photos::PhotoScan scan, Scan(context));
    for (const std::string& warning : scan.warnings) {
      Warn(context, OneLine(warning));
    }
    FREEGS_ASSIGN_OR_RETURN(list->photos, TakeFilms(context, scan));
    for (const std::string& file : scan.files) {
      list->photos.emplace_back().file = file;
    }
    photos::PhotoInspector inspector(options_.decode);
    std::atomic<int> transparent = 0;
    FREEGS_RETURN_IF_ERROR(ForEachPhoto(
        context, "reading photos", list->photos.size(), [&](size_t i) {
          Photo& photo = list->photos[i];
          if (!photo.usable()) return Status();
          const Photo known = photo;
          photos::InspectedPhoto inspected =
              inspector.Inspect(SourceFolder(context, known), known.file);
          if (inspected.may_be_transparent) ++transparent;
          photo = std::move(inspected.photo);
          photo.film = known.film;
          photo.frame = known.frame;
          photo.time_s = known.time_s;
          if (inspected.pixels.empty()) return Status();
          return WriteImage(PendingPath(context, i), inspected.pixels);
        }));
    if (transparent > 0) {
      context.log(LogLevel::kInfo,
                  std::to_string(transparent) +
                      " photos have transparency; where they are transparent "
                      "they are " +
                      options_.decode.background +
                      " now (ingest.background), as reconstruct.background "
                      "should be");
    }
    return Status();
  }

  Status Select(const StageContext& context,
                const photos::HoldoutRule& rule,
                photos::PhotoList* list) const {
    std::vector<Photo>& photos = list->photos;
    photos::RejectDuplicates(&photos);
    const size_t unreadable = WarnOfRejected(context, photos);
    const size_t usable = photos.size() - unreadable;
    if (usable < kMinUsable) return TooFewError(context, photos, usable);
    photos::RejectBlurred(options_.keep_sharpest, &photos);
    if (options_.keep_sharpest < 1) {
      const int rejected = list->Count(PhotoSplit::kRejected);
      context.log(LogLevel::kInfo,
                  "keeping the sharpest " +
                      std::to_string(photos.size() - rejected) + " of " +
                      std::to_string(usable) + " photos");
    }
    photos::AssignNames(&photos);
    const auto unmatched = photos::AssignHoldout(rule, &photos);
    if (!unmatched.ok()) {
      return BadInputError(OneLine(unmatched.status().message()) +
                           " (ingest.holdout_every, ingest.holdout, "
                           "ingest.holdout_list)");
    }
    for (const std::string& name : *unmatched) {
      Warn(context, "holdout: no usable photo is named " + OneLine(name));
    }
    photos::AssignCameraGroups(&photos);
    WarnOfOtherHoldout(context, *list);
    return Status();
  }

  // Moves and copies the usable photos to photos/.
  static Status PlacePhotos(StageContext& context,
                            const photos::PhotoList& list) {
    const fs::path folder = context.output / "photos";
    std::vector<size_t> usable;
    for (size_t i = 0; i < list.photos.size(); ++i) {
      if (!list.photos[i].usable()) continue;
      usable.push_back(i);
      FREEGS_RETURN_IF_ERROR(
          CreateFolders((folder / list.photos[i].name).parent_path()));
    }
    FREEGS_RETURN_IF_ERROR(ForEachPhoto(
        context, "copying photos", usable.size(), [&](size_t k) -> Status {
          const Photo& photo = list.photos[usable[k]];
          const fs::path target = folder / photo.name;
          if (!photo.converted) {
            return CopyPhoto(
                SourceFolder(context, photo) / photo.file, photo, target);
          }
          std::error_code error;
          fs::rename(PendingPath(context, usable[k]), target, error);
          if (!error) return Status();
          return InternalError(target.string() +
                               ": cannot write: " + error.message());
        }));
    std::error_code ignored;
    fs::remove_all(context.output / "pending", ignored);
    fs::remove_all(context.output / "frames", ignored);
    return Status();
  }

  // Copies instead of linking, so that editing a file of the workspace does not
  // change the original.
  static Status CopyPhoto(const fs::path& source,
                          const Photo& photo,
                          const fs::path& target) {
    FREEGS_ASSIGN_OR_RETURN(const std::string bytes, ReadFile(source));
    if (HashBytes(bytes) != photo.file_hash) {
      return BadInputError(source.string() +
                           ": changed while it was being read; run again when "
                           "it is complete");
    }
    return WriteFileAtomic(target, bytes);
  }

  static void Warn(const StageContext& context, const std::string& text) {
    context.log(LogLevel::kWarning, text);
  }

  // Logs one line per rejected photo and returns their number.
  static size_t WarnOfRejected(const StageContext& context,
                               const std::vector<Photo>& photos) {
    size_t rejected = 0;
    for (const Photo& photo : photos) {
      if (photo.usable()) continue;
      ++rejected;
      Warn(context, OneLine(photo.file) + ": not used: " + photo.reason);
    }
    return rejected;
  }

  static Status TooFewError(const StageContext& context,
                            const std::vector<Photo>& photos,
                            size_t usable) {
    const std::string folder = context.images.string();
    if (photos.empty()) {
      return BadInputError(folder +
                           ": no JPEG, PNG or TIFF photos and no films here or "
                           "below");
    }
    std::string message = folder + ": " + std::to_string(usable) + " of " +
                          std::to_string(photos.size()) +
                          " photos can be used, " + std::to_string(kMinUsable) +
                          " are needed";
    constexpr size_t kShown = 3;
    size_t shown = 0;
    for (const Photo& photo : photos) {
      if (photo.usable() || shown == kShown) continue;
      message += ". " + OneLine(photo.file) + ": " + photo.reason;
      ++shown;
    }
    const size_t rejected = photos.size() - usable;
    if (rejected > shown) {
      message += ". And " + std::to_string(rejected - shown) + " more";
    }
    return BadInputError(message);
  }

  static void Summarise(const photos::PhotoList& list,
                        nlohmann::json* summary) {
    (*summary)["photos"] = list.photos.size();
    (*summary)["train"] = list.Count(PhotoSplit::kTrain);
    (*summary)["holdout"] = list.Count(PhotoSplit::kHoldout);
    nlohmann::json rejected = nlohmann::json::array();
    int groups = 0;
    for (const Photo& photo : list.photos) {
      groups = std::max(groups, photo.camera_group + 1);
      if (!photo.usable()) {
        rejected.push_back({{"file", photo.file}, {"reason", photo.reason}});
      }
    }
    (*summary)["camera_groups"] = groups;
    (*summary)["rejected"] = std::move(rejected);
  }

  IngestStageOptions options_;
};

}  // namespace

std::unique_ptr<pipeline::Stage> MakeIngestStage(
    const IngestStageOptions& options) {
  return std::make_unique<IngestStage>(options);
}

}  // namespace freegs::stages
