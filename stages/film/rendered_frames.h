// SPDX-License-Identifier: BSD-3-Clause
// Which pictures of a folder are frames of a path that `render` wrote there. A
// shorter path removes what a longer one has left, and nothing else: other
// pictures of such a name, like those that FFmpeg makes of a film, are somebody
// else's.

#ifndef FREEGS_STAGES_FILM_RENDERED_FRAMES_H_
#define FREEGS_STAGES_FILM_RENDERED_FRAMES_H_

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "core/status.h"

namespace freegs::stages {

// folder/rendered_frames.json says how many frames (FrameName) the last path
// has written, and how many pictures of them in folder/preview. If it is
// missing or malformed, there are none.

// Before pictures of these names that are no frames are written: frames from
// the first on that one of them replaces are no longer to be removed.
// `previews`: the pictures have some, too. Errors as WriteFileAtomic.
Status ForgetReplacedFrames(const std::filesystem::path& folder,
                            const std::vector<std::string>& names,
                            bool previews);

// After a path has written `count` frames, with previews or without: removes
// what an earlier path wrote beyond them. Returns lines for the user about what
// was removed and what stays; often empty. Errors as WriteFileAtomic.
StatusOr<std::string> RemoveLaterFrames(const std::filesystem::path& folder,
                                        size_t count,
                                        bool previews);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_FILM_RENDERED_FRAMES_H_
