// SPDX-License-Identifier: BSD-3-Clause
// The part of stage ingest that takes photos from films.

#ifndef FREEGS_STAGES_INGEST_INGEST_FILMS_H_
#define FREEGS_STAGES_INGEST_INGEST_FILMS_H_

#include <filesystem>
#include <string>
#include <vector>

#include "core/status.h"
#include "photos/photo_list.h"
#include "photos/video_frames.h"
#include "pipeline/stage.h"

namespace freegs::stages {

// Writes the chosen frames of each film as folder/FILM/frame_NNNNNN.jpg, where
// the number counts all frames of the film from 0. Returns one photo per
// written frame, with only the members file, film, frame and time_s set.
// `films` are paths relative to `films_root`. A film that cannot be used
// becomes one rejected photo; it is kBadInput when it is the only film.
// kInterrupted when cancelled.
StatusOr<std::vector<photos::Photo>> TakeFilmFrames(
    const pipeline::StageContext& context,
    const std::filesystem::path& films_root,
    const std::vector<std::string>& films,
    const photos::VideoFrameOptions& options,
    const std::filesystem::path& folder);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_INGEST_INGEST_FILMS_H_
