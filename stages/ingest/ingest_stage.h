// SPDX-License-Identifier: BSD-3-Clause
// Stage ingest, photo folder or film -> ingest/: collects the photos that can
// be used, and what is known about each of them. The photos are written upright
// and in formats that every later program reads in the same way.
// MakeIngestStage makes the stage; stages/registry/stage_registry.h shows who
// runs it.

#ifndef FREEGS_STAGES_INGEST_INGEST_STAGE_H_
#define FREEGS_STAGES_INGEST_INGEST_STAGE_H_

#include <memory>
#include <string>

#include "core/status.h"
#include "photos/photo_decode.h"
#include "photos/video_frames.h"
#include "pipeline/option_table.h"
#include "pipeline/stage.h"
#include "stages/ingest/ingest_masks.h"

namespace freegs::stages {

struct IngestStageOptions {
  photos::PhotoDecodeOptions decode = {.max_megapixels_option =
                                           "ingest.max_megapixels"};

  // Every holdout_every-th usable photo, beginning with the first, is kept from
  // training; 0 keeps none.
  int holdout_every = 8;

  // A shell pattern of the photos that are kept from training, or "none". It
  // overrides holdout_every unless it is empty.
  std::string holdout;

  // A file with the names of the photos that are kept from training, one per
  // line. It overrides both options above unless it is empty.
  std::string holdout_list;

  // The share of the photos that is kept: the sharpest photo of each stretch of
  // the sequence.
  double keep_sharpest = 1;

  // Which frames of a film are taken. Its max_megapixels is not used: the stage
  // takes that of `decode`.
  photos::VideoFrameOptions film;

  IngestMaskOptions masks;

  // kInvalidArgument, naming the option, for a value that is not allowed.
  Status Check() const;
};

// Adds section [ingest] to the table, which keeps pointers to `options`.
void RegisterIngestOptions(IngestStageOptions& options,
                           pipeline::OptionTable& table);

// Reads the folder or film of context.images. Writes
//   images.json   what is known about each photo (photos/photo_list.h)
//   photos/       the usable photos
//   masks/        their masks, if there are any
// A photo that cannot be used is rejected with a warning. kBadInput when fewer
// than three can be used.
std::unique_ptr<pipeline::Stage> MakeIngestStage(
    const IngestStageOptions& options);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_INGEST_INGEST_STAGE_H_
