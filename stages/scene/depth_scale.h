// SPDX-License-Identifier: BSD-3-Clause
// depth.json: what the pixel values of depth pictures in a folder mean.

#ifndef FREEGS_STAGES_SCENE_DEPTH_SCALE_H_
#define FREEGS_STAGES_SCENE_DEPTH_SCALE_H_

#include <filesystem>
#include <string>
#include <vector>

#include "core/status.h"
#include "stages/scene/depth_image.h"

namespace freegs::stages {

// Writes folder/depth.json before pictures of these names are made, with the
// unit of their pixel values and the range of their depths. The file lists the
// pictures in the folder that have its unit. Where that changes, those that are
// about to be made anew are removed first, so that none has a wrong unit if
// that is interrupted. Returns kInvalidArgument if others would stay. Other
// errors are those of WriteFileAtomic.
Status WriteDepthScale(const std::filesystem::path& folder,
                       double unit,
                       const DepthRange& range,
                       const std::vector<std::string>& names);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_DEPTH_SCALE_H_
