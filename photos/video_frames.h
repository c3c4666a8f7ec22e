// SPDX-License-Identifier: BSD-3-Clause
// Takes frames of a film as photos: sharp ones that are spread evenly over the
// movement of the picture.
//
//   FREEGS_ASSIGN_OR_RETURN(
//       const VideoSurvey survey,
//       SurveyVideo(path, options, progress, cancellation));
//   const auto chosen = ChooseVideoFrames(survey.frames, options);
//   FREEGS_RETURN_IF_ERROR(ReadVideoFrames(path, chosen, save, cancellation));

#ifndef FREEGS_PHOTOS_VIDEO_FRAMES_H_
#define FREEGS_PHOTOS_VIDEO_FRAMES_H_

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>
#include <vector>

#include "core/cancellation.h"
#include "core/image.h"
#include "core/status.h"

namespace freegs::photos {

struct VideoFrameOptions {
  // One frame is taken each time the picture has moved by this share of its
  // width.
  double motion = 0.05;

  // The most and the fewest frames to take; `motion` is adapted to fit. But a
  // film whose picture moves by less than `motion` in all gives one frame.
  int max_frames = 300;
  int min_frames = 20;

  // Limit in millions of pixels; larger frames are refused.
  double max_megapixels = 400;

  // The option that sets this limit, for messages; empty where none does.
  std::string max_megapixels_option = {};

  Status Check() const;
};

struct VideoFrame {
  int number = 0;        // From 0, as decoded.
  double time_s = 0;     // From the start of the film.
  double sharpness = 0;  // See photo_pixels.h.

  // How far the picture has moved since the first frame, in widths of the
  // picture (see PictureMotion). It never decreases.
  double path = 0;
};

struct VideoSurvey {
  int width = 0;  // Pixels, upright.
  int height = 0;
  std::vector<VideoFrame> frames;  // All that could be decoded, in order.
  int64_t claimed_frames = 0;      // As the file says; 0 when it says nothing.
};

// Whether a file begins like a film of a known kind: MP4, QuickTime, Matroska,
// WebM, AVI, MPEG stream, FLV, ASF or Ogg. `first_bytes` should hold at least
// the first 200 bytes.
bool LooksLikeVideo(std::string_view first_bytes);

// Decodes all frames once and measures them. Returns kBadInput when the file is
// not a film, when nothing in it can be decoded, and when frames are larger
// than allowed; the message names the file and says what to do. Returns
// kMissingDependency if OpenCV was built without FFmpeg.
StatusOr<VideoSurvey> SurveyVideo(const std::filesystem::path& path,
                                  const VideoFrameOptions& options,
                                  const ProgressFn& progress,
                                  const CancellationToken* cancellation);

// Chooses the frames to take and returns them in order. The path of the film is
// cut into stretches of equal length. The sharpest frame of each stretch, or
// the first of several equally sharp ones, is taken, unless it is far blurrier
// than those of the neighbouring stretches.
std::vector<VideoFrame> ChooseVideoFrames(const std::vector<VideoFrame>& frames,
                                          const VideoFrameOptions& options);

// Decodes the film again and calls on_frame with the pixels of each chosen
// frame: 8-bit RGB, turned upright as the file asks. `chosen` is in order.
// Returns kBadInput if the film has changed meanwhile.
Status ReadVideoFrames(
    const std::filesystem::path& path,
    const std::vector<VideoFrame>& chosen,
    const std::function<Status(const VideoFrame&, const ImageU8&)>& on_frame,
    const CancellationToken* cancellation);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_VIDEO_FRAMES_H_
