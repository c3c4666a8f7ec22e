// SPDX-License-Identifier: BSD-3-Clause
// The frames of a film that are worth being photos: sharp ones, spread evenly
// over the movement of the picture.

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

  // Most and fewest frames taken; the share above is stretched to fit. A film
  // whose picture moves by less than one share gives one frame.
  int max_frames = 300;
  int min_frames = 20;

  // Larger frames are refused (millions of pixels).
  double max_megapixels = 400;

  Status Check() const;
};

struct VideoFrame {
  int number = 0;        // From 0, as decoded.
  double time_s = 0;     // From the start of the film.
  double sharpness = 0;  // See photo_pixels.h.

  // How far the picture has moved since the first frame, in widths of it: the
  // sum of the median displacements of features that are followed from frame to
  // frame. Never decreases. Trembling on one spot adds nothing.
  double path = 0;
};

struct VideoSurvey {
  int width = 0;  // Pixels, upright.
  int height = 0;
  std::vector<VideoFrame> frames;  // All that could be decoded, in order.
  int64_t claimed_frames = 0;      // As the file says; 0 when it does not.
};

// Whether a file begins like a film of a kind that we read: MP4 and QuickTime,
// Matroska and WebM, AVI, MPEG streams, FLV, ASF, Ogg. At least the first 200
// bytes.
bool LooksLikeVideo(std::string_view first_bytes);

// Decodes all frames once and measures them. kBadInput, naming the file, what
// is wrong with it and what to do: not a film, nothing that can be decoded,
// frames larger than allowed. kMissingDependency if OpenCV was built without
// FFmpeg.
StatusOr<VideoSurvey> SurveyVideo(const std::filesystem::path& path,
                                  const VideoFrameOptions& options,
                                  const ProgressFn& progress,
                                  const CancellationToken* cancellation);

// The frames to take: the film's path is cut into equal stretches, and the
// sharpest frame of each stays (the first of equals), unless it is far blurrier
// than its neighbours. In order.
std::vector<VideoFrame> ChooseVideoFrames(const std::vector<VideoFrame>& frames,
                                          const VideoFrameOptions& options);

// Decodes the film again and hands over the pixels (8-bit RGB, turned upright
// as the file's rotation says) of the chosen frames, which are in order.
// kBadInput if the film has changed meanwhile.
Status ReadVideoFrames(
    const std::filesystem::path& path,
    const std::vector<VideoFrame>& chosen,
    const std::function<Status(const VideoFrame&, const ImageU8&)>& on_frame,
    const CancellationToken* cancellation);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_VIDEO_FRAMES_H_
