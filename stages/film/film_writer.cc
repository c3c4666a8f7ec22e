// SPDX-License-Identifier: BSD-3-Clause

#include "stages/film/film_writer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <string>
#include <system_error>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <opencv2/videoio/registry.hpp>

#include "core/io/files.h"
#include "core/out_of_memory.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

bool HasWriter() {
  for (const cv::VideoCaptureAPIs api :
       cv::videoio_registry::getWriterBackends()) {
    if (api == cv::CAP_FFMPEG) return true;
  }
  return false;
}

// Pictures that can be decoded from a film.
int64_t CountPictures(const fs::path& path) {
  cv::VideoCapture film(path.string(), cv::CAP_FFMPEG);
  return film.isOpened() ? std::llround(film.get(cv::CAP_PROP_FRAME_COUNT)) : 0;
}

}  // namespace

struct FilmWriter::State {
  fs::path path;
  fs::path partial;  // FFmpeg takes the container from the suffix.
  int width = 0;
  int height = 0;
  int64_t count = 0;
  cv::VideoWriter writer;
};

Status CheckFilmPath(const fs::path& path) {
  if (path.extension() != ".mp4") {
    return InvalidArgumentError(path.string() + ": films are .mp4 files");
  }
  if (!HasWriter()) {
    return MissingDependencyError(
        path.string() +
        ": OpenCV was built without FFmpeg and writes no films; install OpenCV "
        "with it, or write pictures with --out DIR and join them with another "
        "program");
  }
  return Status();
}

FilmWriter::FilmWriter(std::unique_ptr<State> state)
    : state_(std::move(state)) {}

FilmWriter::~FilmWriter() {
  state_->writer.release();
  std::error_code error;
  fs::remove(state_->partial, error);
}

StatusOr<std::unique_ptr<FilmWriter>> FilmWriter::Open(const fs::path& path,
                                                       int width,
                                                       int height,
                                                       double fps) {
  FREEGS_RETURN_IF_ERROR(CheckFilmPath(path));
  if (width < 2 || height < 2 || width % 2 != 0 || height % 2 != 0) {
    return InvalidArgumentError("a film needs an even width and height, not " +
                                std::to_string(width) + " x " +
                                std::to_string(height));
  }
  constexpr int kMaxSide = 8190;  // MPEG-4 has 13 bits, and it is even.
  if (std::max(width, height) > kMaxSide) {
    return InvalidArgumentError(
        "a film has at most " + std::to_string(kMaxSide) +
        " pixels a side, not " + std::to_string(width) + " x " +
        std::to_string(height) + "; limit it with --size");
  }
  // MPEG-4 writes the rate as a fraction of numbers of 16 bits, and OpenCV
  // takes thousandths.
  if (fps > 65) fps = std::round(100 * fps) / 100;
  auto state = std::make_unique<State>();
  // The absolute path: "a:b" would be a protocol for FFmpeg.
  std::error_code error;
  state->path = fs::absolute(path, error);
  state->partial = state->path;
  state->partial.replace_extension(".partial.mp4");
  state->width = width;
  state->height = height;
  try {
    state->writer.open(state->partial.string(),
                       cv::CAP_FFMPEG,
                       cv::VideoWriter::fourcc('m', 'p', '4', 'v'),
                       fps,
                       cv::Size(width, height));
  } catch (const std::exception& fault) {
    if (IsOutOfMemory(fault)) throw;
    return BadInputError(path.string() + ": " + fault.what());
  }
  if (!state->writer.isOpened()) {
    return BadInputError(path.string() + ": cannot be written as a film of " +
                         std::to_string(width) + " x " +
                         std::to_string(height) +
                         " pixels; is the folder writable, and has FFmpeg an "
                         "encoder for MPEG-4?");
  }
  return std::unique_ptr<FilmWriter>(new FilmWriter(std::move(state)));
}

Status FilmWriter::Write(const ImageU8& picture) {
  if (picture.width() != state_->width || picture.height() != state_->height ||
      picture.channels() != 3) {
    return InvalidArgumentError("a picture has not the size of the film");
  }
  try {
    const cv::Mat rgb(picture.height(),
                      picture.width(),
                      CV_8UC3,
                      const_cast<uint8_t*>(picture.data()));
    cv::Mat bgr;
    cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
    state_->writer.write(bgr);
  } catch (const std::exception& fault) {
    if (IsOutOfMemory(fault)) throw;
    return InternalError(state_->path.string() + ": " + fault.what());
  }
  ++state_->count;
  return Status();
}

Status FilmWriter::Close() {
  state_->writer.release();
  // OpenCV does not tell when writing fails.
  if (CountPictures(state_->partial) != state_->count) {
    return InternalError(state_->path.string() +
                         ": the film was not written whole; is the disk full?");
  }
  FREEGS_RETURN_IF_ERROR(FlushToDisk(state_->partial));
  std::error_code error;
  fs::rename(state_->partial, state_->path, error);
  if (error) {
    return InternalError(state_->path.string() + ": " + error.message());
  }
  return FlushToDisk(state_->path.parent_path());
}

}  // namespace freegs::stages
