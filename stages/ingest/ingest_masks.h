// SPDX-License-Identifier: BSD-3-Clause
// The part of stage ingest that brings masks into the workspace.

#ifndef FREEGS_STAGES_INGEST_INGEST_MASKS_H_
#define FREEGS_STAGES_INGEST_INGEST_MASKS_H_

#include <filesystem>
#include <string>

#include "core/status.h"
#include "photos/photo_decode.h"
#include "photos/photo_list.h"
#include "pipeline/stage.h"

namespace freegs::stages {

struct IngestMaskOptions {
  // Whether masks are used. When they are not, a folder `masks` among the
  // photos is a folder of photos like any other.
  bool use_masks = true;

  // The folder of masks. Empty takes the folder `masks` in the photo folder if
  // it exists.
  std::string masks;

  // True when white marks what is ignored, false when black does.
  bool invert_masks = false;
};

// Returns the folder of masks for the photos in `images`, or an empty path when
// there is none. kBadInput when the folder that the options name does not
// exist, and when the masks lie in the photo folder itself.
StatusOr<std::filesystem::path> FindMaskFolder(
    const std::filesystem::path& images, const IngestMaskOptions& options);

// Writes the mask of each usable photo as masks/NAME.png below context.output:
// the photo's size, 255 where the photo is looked at and 0 where it is ignored.
// When at least one photo has a mask, the photos without one get a white mask.
// Sets has_mask of the photos, warns of masks that cannot be used, and adds
// counts to context.summary. Does nothing when mask_folder is empty.
Status PlaceMasks(pipeline::StageContext& context,
                  const std::filesystem::path& mask_folder,
                  const IngestMaskOptions& options,
                  const photos::PhotoDecodeOptions& decode,
                  photos::PhotoList* list);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_INGEST_INGEST_MASKS_H_
