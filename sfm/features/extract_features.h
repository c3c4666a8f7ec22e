// SPDX-License-Identifier: BSD-3-Clause
// The step that finds the features of all photos.
//
//   FREEGS_RETURN_IF_ERROR(RegisterPhotos(context, database));
//   FREEGS_RETURN_IF_ERROR(ExtractFeatures(context, database));

#ifndef FREEGS_SFM_FEATURES_EXTRACT_FEATURES_H_
#define FREEGS_SFM_FEATURES_EXTRACT_FEATURES_H_

#include <filesystem>

#include "core/status.h"
#include "sfm/colmap/colmap_steps.h"

namespace freegs::sfm {

// Finds the features of all photos in the database that have none, with
// options.max_image_size and max_features, and writes them into it. Returns
// kBadInput when a photo or mask cannot be read. The result does not depend on
// the number of threads.
Status ExtractFeatures(const StepContext& context,
                       const std::filesystem::path& database);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_FEATURES_EXTRACT_FEATURES_H_
