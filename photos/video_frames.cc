// SPDX-License-Identifier: BSD-3-Clause

#include "photos/video_frames.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <fstream>
#include <optional>
#include <string>
#include <utility>

#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <opencv2/videoio/registry.hpp>

#include "core/number_text.h"
#include "core/out_of_memory.h"
#include "core/quantile.h"
#include "photos/film_rotation.h"
#include "photos/photo_pixels.h"
#include "photos/picture_motion.h"

namespace freegs::photos {
namespace {

namespace fs = std::filesystem;

constexpr size_t kFilmSignatureBytes = 400;
constexpr int kMotionWidth = 320;    // Width of the followed picture.
constexpr double kStepShare = 0.25;  // Share of VideoFrameOptions::motion.
constexpr int kMaxDecoded = 1 << 24;

// Chosen frames of less than this share of the median sharpness of the chosen
// ones around them are dropped.
constexpr double kMinSharpnessShare = 0.2;
constexpr size_t kNeighbours = 20;  // On each side.

Status Fault(const fs::path& path, const std::string& what) {
  return BadInputError(path.string() + ": " + what);
}

Status CheckSignature(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) {
    return Fault(path, "cannot be read as a film: not a regular file");
  }
  if (fs::file_size(path, error) == 0) {
    return Fault(path, "empty file (0 bytes); copy the film again");
  }
  std::ifstream file(path, std::ios::binary);
  std::string bytes(kFilmSignatureBytes, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (file.gcount() <= 0) {
    return Fault(path, "cannot be read; make it readable");
  }
  bytes.resize(static_cast<size_t>(file.gcount()));
  if (LooksLikeVideo(bytes)) return Status();
  return Fault(path,
               "not a film of a kind that is read here (MP4, MOV, MKV, WebM, "
               "AVI, MPEG, ...); convert it, or give a folder of photos");
}

// A film that is being decoded.
class Film {
 public:
  static StatusOr<Film> Open(const fs::path& path) {
    FREEGS_RETURN_IF_ERROR(CheckSignature(path));
    if (!cv::videoio_registry::hasBackend(cv::CAP_FFMPEG)) {
      return MissingDependencyError(
          path.string() +
          ": OpenCV was built without FFmpeg and reads no films; install "
          "OpenCV with it, or take the frames out with another program");
    }
    Film film;
    // The absolute path: "a:b" would be a protocol for FFmpeg.
    std::error_code error;
    const std::string name = fs::absolute(path, error).string();
    film.capture_.open(name, cv::CAP_FFMPEG);
    if (!film.capture_.isOpened()) {
      return Fault(path,
                   "cannot be opened as a film: truncated or damaged; copy it "
                   "again or convert it");
    }
    film.capture_.set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
    film.rotation_ = FilmRotation(path);
    return film;
  }

  double Property(int id) const {
    const double value = capture_.get(id);
    return std::isfinite(value) && value > 0 ? value : 0;
  }

  // False at the end.
  bool Next() { return capture_.grab(); }
  // The upright frame, 8-bit BGR. False if it cannot be had.
  bool Pixels(cv::Mat* bgr) {
    cv::Mat& stored = rotation_ == 0 ? *bgr : stored_;
    if (!capture_.retrieve(stored) || stored.empty()) return false;
    if (rotation_ == 90) cv::rotate(stored, *bgr, cv::ROTATE_90_CLOCKWISE);
    if (rotation_ == 180) cv::rotate(stored, *bgr, cv::ROTATE_180);
    if (rotation_ == 270) {
      cv::rotate(stored, *bgr, cv::ROTATE_90_COUNTERCLOCKWISE);
    }
    return true;
  }

 private:
  int rotation_ = 0;  // Degrees, clockwise.
  cv::Mat stored_;
  cv::VideoCapture capture_;
};

// Calls `decode`, which runs OpenCV on a file that may be anything.
Status Guarded(const fs::path& path, const std::function<Status()>& decode) {
  try {
    return decode();
  } catch (const std::exception& error) {
    if (IsOutOfMemory(error)) throw;
    return Fault(path,
                 std::string("cannot be decoded (") + error.what() +
                     "); convert it or copy it again");
  }
}

// False for anything but 8-bit colour.
bool ToRgb(const cv::Mat& bgr, ImageU8* rgb) {
  if (bgr.type() != CV_8UC3) return false;
  rgb->Reshape(bgr.cols, bgr.rows, 3);
  cv::Mat target(bgr.rows, bgr.cols, CV_8UC3, rgb->data());
  cv::cvtColor(bgr, target, cv::COLOR_BGR2RGB);
  return true;
}

cv::Mat SmallGrey(const cv::Mat& bgr) {
  cv::Mat grey;
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  if (grey.cols <= kMotionWidth) return grey;
  const int height = std::max(1,
                              static_cast<int>(std::lround(
                                  1.0 * grey.rows * kMotionWidth / grey.cols)));
  cv::Mat small;
  cv::resize(grey, small, {kMotionWidth, height}, 0, 0, cv::INTER_AREA);
  return small;
}

Status Survey(const fs::path& path,
              const VideoFrameOptions& options,
              const ProgressFn& progress,
              const CancellationToken* cancellation,
              VideoSurvey* survey) {
  FREEGS_ASSIGN_OR_RETURN(Film film, Film::Open(path));
  const double megapixels = film.Property(cv::CAP_PROP_FRAME_WIDTH) *
                            film.Property(cv::CAP_PROP_FRAME_HEIGHT) / 1e6;
  if (megapixels > options.max_megapixels) {
    return Fault(path,
                 "its frames claim to have " +
                     std::to_string(std::llround(megapixels)) +
                     " megapixels, more than the limit of " +
                     FormatSignificant(options.max_megapixels, 6) +
                     (options.max_megapixels_option.empty()
                          ? ""
                          : " (" + options.max_megapixels_option + ")"));
  }
  const double fps = film.Property(cv::CAP_PROP_FPS);
  const double claimed = film.Property(cv::CAP_PROP_FRAME_COUNT);
  survey->claimed_frames = static_cast<int64_t>(std::min(claimed, 1e15));
  PictureMotion motion(kStepShare * options.motion);
  cv::Mat bgr;
  ImageU8 rgb;
  for (int number = 0; number < kMaxDecoded && film.Next(); ++number) {
    if (IsCancelled(cancellation)) {
      return InterruptedError("stopped while reading a film");
    }
    if (!film.Pixels(&bgr) || !ToRgb(bgr, &rgb)) continue;
    if (survey->frames.empty()) {
      survey->width = bgr.cols;
      survey->height = bgr.rows;
    }
    if (bgr.cols != survey->width || bgr.rows != survey->height) continue;
    VideoFrame frame;
    frame.number = number;
    const double time = film.Property(cv::CAP_PROP_POS_MSEC) / 1000;
    frame.time_s = time > 0 || fps == 0 ? time : number / fps;
    frame.sharpness = Sharpness(rgb);
    frame.path = motion.Add(SmallGrey(bgr));
    survey->frames.push_back(frame);
    if (progress) {
      progress(
          {"reading the film",
           static_cast<double>(number + 1),
           std::max(static_cast<double>(survey->claimed_frames), number + 1.0),
           ""});
    }
  }
  if (survey->frames.empty()) {
    return Fault(path,
                 "not one frame can be decoded: truncated, damaged, or without "
                 "pictures; copy it again or convert it");
  }
  return Status();
}

std::vector<VideoFrame> DropBlurred(const std::vector<VideoFrame>& chosen) {
  std::vector<VideoFrame> kept;
  for (size_t i = 0; i < chosen.size(); ++i) {
    const size_t first = i > kNeighbours ? i - kNeighbours : 0;
    const size_t last = std::min(chosen.size(), i + kNeighbours + 1);
    std::vector<double> around;
    for (size_t k = first; k < last; ++k) around.push_back(chosen[k].sharpness);
    if (chosen[i].sharpness >=
        kMinSharpnessShare * UpperMedian(std::move(around))) {
      kept.push_back(chosen[i]);
    }
  }
  return kept;
}

}  // namespace

Status VideoFrameOptions::Check() const {
  if (!(motion > 0 && motion <= 1)) {
    return InvalidArgumentError("video_motion must be in (0, 1]");
  }
  if (!(max_megapixels > 0)) {
    return InvalidArgumentError("max_megapixels must be positive");
  }
  if (min_frames < 3 || max_frames < 3) {
    return InvalidArgumentError(
        "min_frames and video_frames must be at least 3");
  }
  return Status();
}

bool LooksLikeVideo(std::string_view bytes) {
  const auto has = [&bytes](size_t at, std::string_view text) {
    return bytes.size() >= at + text.size() &&
           bytes.substr(at, text.size()) == text;
  };
  using namespace std::string_view_literals;
  for (const std::string_view box :
       {"ftyp"sv, "moov"sv, "mdat"sv, "wide"sv, "free"sv, "skip"sv}) {
    if (has(4, box)) return true;  // ISO 14496-12 and QuickTime.
  }
  if (has(0, "RIFF"sv) && has(8, "AVI "sv)) return true;
  for (const std::string_view start : {"\x1a\x45\xdf\xa3"sv,  // Matroska.
                                       "\0\0\1\xba"sv,  // MPEG program stream.
                                       "\0\0\1\xb3"sv,  // MPEG video.
                                       "FLV\1"sv,
                                       "\x30\x26\xb2\x75"sv,  // ASF.
                                       "OggS"sv}) {
    if (has(0, start)) return true;
  }
  // MPEG transport streams: packets of 188 bytes, with 4 more on some discs.
  return (has(0, "G"sv) && has(188, "G"sv)) ||
         (has(4, "G"sv) && has(196, "G"sv));
}

StatusOr<VideoSurvey> SurveyVideo(const fs::path& path,
                                  const VideoFrameOptions& options,
                                  const ProgressFn& progress,
                                  const CancellationToken* cancellation) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  VideoSurvey survey;
  FREEGS_RETURN_IF_ERROR(Guarded(path, [&] {
    return Survey(path, options, progress, cancellation, &survey);
  }));
  return survey;
}

std::vector<VideoFrame> ChooseVideoFrames(const std::vector<VideoFrame>& frames,
                                          const VideoFrameOptions& options) {
  if (frames.empty()) return {};
  const double length = frames.back().path - frames.front().path;
  int64_t windows = 1;
  if (length >= options.motion) {
    // Bounded before rounding: the quotient may be large.
    const double wanted = std::min(length / options.motion, 1e9);
    windows =
        std::clamp<int64_t>(std::llround(wanted),
                            std::min(options.min_frames, options.max_frames),
                            options.max_frames);
  }
  std::vector<std::optional<VideoFrame>> best(static_cast<size_t>(windows));
  for (const VideoFrame& frame : frames) {
    int64_t window = 0;
    if (windows > 1) {
      const double share = (frame.path - frames.front().path) / length;
      window = std::clamp<int64_t>(
          static_cast<int64_t>(share * static_cast<double>(windows)),
          0,
          windows - 1);
    }
    std::optional<VideoFrame>& sharpest = best[static_cast<size_t>(window)];
    if (!sharpest || frame.sharpness > sharpest->sharpness) sharpest = frame;
  }
  std::vector<VideoFrame> chosen;
  for (const std::optional<VideoFrame>& frame : best) {
    if (frame) chosen.push_back(*frame);
  }
  return DropBlurred(chosen);
}

Status ReadVideoFrames(
    const fs::path& path,
    const std::vector<VideoFrame>& chosen,
    const std::function<Status(const VideoFrame&, const ImageU8&)>& on_frame,
    const CancellationToken* cancellation) {
  return Guarded(path, [&]() -> Status {
    FREEGS_ASSIGN_OR_RETURN(Film film, Film::Open(path));
    cv::Mat bgr;
    ImageU8 rgb;
    size_t next = 0;
    for (int number = 0; next < chosen.size() && film.Next(); ++number) {
      if (IsCancelled(cancellation)) {
        return InterruptedError("stopped while reading a film");
      }
      if (number != chosen[next].number) continue;
      if (!film.Pixels(&bgr) || !ToRgb(bgr, &rgb)) break;
      FREEGS_RETURN_IF_ERROR(on_frame(chosen[next], rgb));
      ++next;
    }
    if (next == chosen.size()) return Status();
    return Fault(path,
                 "changed while it was being read; run again when it is "
                 "complete");
  });
}

}  // namespace freegs::photos
