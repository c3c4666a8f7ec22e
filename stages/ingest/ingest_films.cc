// SPDX-License-Identifier: BSD-3-Clause

#include "stages/ingest/ingest_films.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/number_text.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using pipeline::LogLevel;
using pipeline::StageContext;

constexpr size_t kMinFrames = 3;

std::string FrameName(int number) {
  char name[32];
  std::snprintf(name, sizeof(name), "frame_%06d.jpg", number);
  return name;
}

// Frames that are farther apart, in widths of the picture, may not overlap
// enough for their poses to be found.
constexpr double kWideGap = 0.3;

// What is worth a warning about the frames that were chosen; often empty.
std::string DoubtsAboutFrames(const std::vector<photos::VideoFrame>& chosen,
                              const photos::VideoFrameOptions& options) {
  size_t widest = 1;
  const auto gap = [&chosen](size_t i) {
    return chosen[i].path - chosen[i - 1].path;
  };
  for (size_t i = 2; i < chosen.size(); ++i) {
    if (gap(i) > gap(widest)) widest = i;
  }
  if (gap(widest) <= kWideGap) return "";
  std::string text =
      "between " + FormatFixed(chosen[widest - 1].time_s, 1) + " s and " +
      FormatFixed(chosen[widest].time_s, 1) + " s the picture moves by " +
      FormatFixed(gap(widest), 2) +
      " of its width without a frame that is taken, which may be too much; ";
  // Sharp frames of neighbouring stretches are at most two stretches apart.
  const double of_many = chosen.back().path / options.max_frames;
  if (2 * std::max(of_many, options.motion) > kWideGap) {
    return text + (of_many > options.motion
                       ? "the film is long: raise --ingest.video_frames"
                       : "lower --ingest.video_motion");
  }
  return text + "frames there are blurred: move the camera more slowly";
}

StatusOr<std::vector<photos::Photo>> TakeFrames(
    const StageContext& context,
    const fs::path& path,
    const std::string& film,
    const photos::VideoFrameOptions& options,
    const fs::path& folder) {
  FREEGS_ASSIGN_OR_RETURN(
      const photos::VideoSurvey survey,
      photos::SurveyVideo(
          path, options, context.progress, context.cancellation));
  const std::vector<photos::VideoFrame> chosen =
      photos::ChooseVideoFrames(survey.frames, options);
  const std::string moved = FormatFixed(survey.frames.back().path, 2);
  if (chosen.size() < kMinFrames) {
    return BadInputError(
        path.string() + ": its picture moves by only " + moved +
        " of its width in " + std::to_string(survey.frames.size()) +
        " frames: too little to see the scene from several sides; move the "
        "camera, or lower ingest.video_motion");
  }
  if (static_cast<double>(survey.frames.size()) <
      0.9 * static_cast<double>(survey.claimed_frames)) {
    context.log(LogLevel::kWarning,
                film + ": only " + std::to_string(survey.frames.size()) +
                    " of " + std::to_string(survey.claimed_frames) +
                    " frames can be decoded; is the film complete?");
  }
  const std::string doubts = DoubtsAboutFrames(chosen, options);
  if (!doubts.empty()) {
    context.log(LogLevel::kWarning, film + ": " + doubts);
  }
  FREEGS_RETURN_IF_ERROR(CreateFolders(folder / film));
  std::vector<photos::Photo> photos;
  const auto on_frame = [&](const photos::VideoFrame& frame,
                            const ImageU8& pixels) -> Status {
    photos::Photo photo;
    photo.file = film + "/" + FrameName(frame.number);
    photo.film = film;
    photo.frame = frame.number;
    photo.time_s = frame.time_s;
    FREEGS_RETURN_IF_ERROR(WriteImage(folder / photo.file, pixels));
    photos.push_back(std::move(photo));
    context.progress({"taking frames",
                      static_cast<double>(photos.size()),
                      static_cast<double>(chosen.size()),
                      ""});
    return Status();
  };
  FREEGS_RETURN_IF_ERROR(
      photos::ReadVideoFrames(path, chosen, on_frame, context.cancellation));
  context.log(LogLevel::kInfo,
              film + ": " + std::to_string(photos.size()) + " of " +
                  std::to_string(survey.frames.size()) +
                  " frames taken; the picture moves by " + moved +
                  " of its width");
  return photos;
}

}  // namespace

StatusOr<std::vector<photos::Photo>> TakeFilmFrames(
    const StageContext& context,
    const fs::path& films_root,
    const std::vector<std::string>& films,
    const photos::VideoFrameOptions& options,
    const fs::path& folder) {
  std::vector<photos::Photo> photos;
  for (const std::string& film : films) {
    StatusOr<std::vector<photos::Photo>> frames =
        TakeFrames(context, films_root / film, film, options, folder);
    if (frames.ok()) {
      photos.insert(photos.end(), frames->begin(), frames->end());
      continue;
    }
    const bool about_film = frames.status().code() == StatusCode::kBadInput;
    if (!about_film || films.size() == 1) return frames.status();
    photos::Photo rejected;
    rejected.file = film;
    rejected.split = photos::PhotoSplit::kRejected;
    rejected.reason = frames.status().message();
    photos.push_back(std::move(rejected));
  }
  return photos;
}

}  // namespace freegs::stages
