// SPDX-License-Identifier: BSD-3-Clause
// Writes a film, picture by picture.

#ifndef FREEGS_STAGES_FILM_FILM_WRITER_H_
#define FREEGS_STAGES_FILM_FILM_WRITER_H_

#include <filesystem>
#include <memory>
#include <string_view>

#include "core/image.h"
#include "core/status.h"

namespace freegs::stages {

// Checks before anything is done that a film can be written there:
// kInvalidArgument for a suffix other than .mp4, kMissingDependency when OpenCV
// was built without FFmpeg.
Status CheckFilmPath(const std::filesystem::path& path);

// MPEG-4 in an .mp4 file:
//
//   FREEGS_ASSIGN_OR_RETURN(const std::unique_ptr<FilmWriter> film,
//                           FilmWriter::Open("orbit.mp4", 640, 480, 30));
//   for (const ImageU8& picture : pictures) {
//     FREEGS_RETURN_IF_ERROR(film->Write(picture));
//   }
//   FREEGS_RETURN_IF_ERROR(film->Close());
//
// The film appears under its name when it is closed. Without Close() nothing is
// left of it.
class FilmWriter {
 public:
  // Width and height are even. Errors of CheckFilmPath, and kBadInput when the
  // file cannot be made.
  static StatusOr<std::unique_ptr<FilmWriter>> Open(
      const std::filesystem::path& path, int width, int height, double fps);

  FilmWriter(const FilmWriter&) = delete;
  FilmWriter& operator=(const FilmWriter&) = delete;
  ~FilmWriter();

  // H x W x 3 RGB of the film's size.
  Status Write(const ImageU8& picture);

  // kInternal when not all pictures have reached the file, as on a full disk.
  Status Close();

 private:
  struct State;
  explicit FilmWriter(std::unique_ptr<State> state);

  std::unique_ptr<State> state_;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_FILM_FILM_WRITER_H_
