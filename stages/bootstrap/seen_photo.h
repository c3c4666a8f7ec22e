// SPDX-License-Identifier: BSD-3-Clause

#ifndef FREEGS_STAGES_BOOTSTRAP_SEEN_PHOTO_H_
#define FREEGS_STAGES_BOOTSTRAP_SEEN_PHOTO_H_

#include <filesystem>

#include "core/image.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

// The photograph of a view, RGB, of undistort/images. Where the mask in
// undistort/masks ignores it, the scene is drawn instead, so that what walked
// through the picture tells nothing about the things behind it. Where training
// learnt exposures, the scene is drawn in that of the photograph, or in the one
// to expect of it when training did not see it (splat::ExposureBetween). May be
// called on several threads at once. Fails when a file cannot be read, and when
// the mask is of another size.
StatusOr<ImageU8> ReadSeenPhoto(const std::filesystem::path& workspace,
                                const WorkspaceScene& scene,
                                const View& view);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BOOTSTRAP_SEEN_PHOTO_H_
