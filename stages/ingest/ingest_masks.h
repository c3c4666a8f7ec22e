// SPDX-License-Identifier: BSD-3-Clause
// The part of the stage ingest that takes over masks.

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
  // Whether masks are used. If not, a folder `masks` among the photos is a
  // folder of photos like any other.
  bool use_masks = true;

  // The folder of masks; empty for `masks` in the photo folder, if there is
  // one.
  std::string masks;

  // True if white is what shall be ignored.
  bool invert_masks = false;
};

// The folder of masks for these photos, or empty if there is none. kBadInput
// if the one that the options name is not a folder.
StatusOr<std::filesystem::path> FindMaskFolder(
    const std::filesystem::path& images, const IngestMaskOptions& options);

// Writes the masks of usable photos as output/masks/NAME.png (0: ignore, 255:
// look at; the photo's size), sets has_mask, warns of masks that cannot be used
// and adds counts to the context's summary. If any photo has a mask, the others
// get a white one. Nothing if mask_folder is empty.
Status PlaceMasks(pipeline::StageContext& context,
                  const std::filesystem::path& mask_folder,
                  const IngestMaskOptions& options,
                  const photos::PhotoDecodeOptions& decode,
                  photos::PhotoList* list);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_INGEST_INGEST_MASKS_H_
