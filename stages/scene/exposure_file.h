// SPDX-License-Identifier: BSD-3-Clause
// reconstruct/exposure.json: what training learnt about the exposure of each
// photograph. It has the layout that the program of 3DGS writes: an object with
// the name of each photograph, and for it 3 rows of 4 numbers E. With colours
// of R, G, B from 0 to 1, channel k of the photograph is
//   photo[k] = sum over j of scene[j] * E[j][k], plus E[k][3].
// So the first three columns are the transpose of those of splat::AffineColor.

#ifndef FREEGS_STAGES_SCENE_EXPOSURE_FILE_H_
#define FREEGS_STAGES_SCENE_EXPOSURE_FILE_H_

#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"
#include "splat/optim/exposure.h"

namespace freegs::stages {

Status WriteExposures(const std::filesystem::path& path,
                      std::span<const splat::PhotoExposure> exposures);

// Gives a picture of the scene (H x W x 3) the exposure of a photograph: the
// one that training learnt for it, or the one to expect of it when it is not
// among `exposures` (splat::ExposureBetween). Without any exposures the picture
// stays as it is. `exposures` are in the order of the photographs' names.
ImageF InExposureOf(std::string_view photo,
                    std::span<const splat::PhotoExposure> exposures,
                    ImageF picture,
                    ThreadPool& pool);

// Reads exposures in the order of the photographs' names; empty if there is no
// such file. kBadInput names a file that is malformed.
StatusOr<std::vector<splat::PhotoExposure>> ReadExposures(
    const std::filesystem::path& path);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_EXPOSURE_FILE_H_
