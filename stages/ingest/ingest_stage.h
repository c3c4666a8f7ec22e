// SPDX-License-Identifier: BSD-3-Clause
// Photo folder or film -> ingest/: the photos that can be used, upright and in
// formats that every later program reads the same way, and what is known about
// them.

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
  photos::PhotoDecodeOptions decode;

  // Every holdout_every-th usable photo, from the first, is kept from training;
  // 0 keeps none.
  int holdout_every = 8;

  // Shell pattern of the photos kept from training, or "none"; empty leaves it
  // to holdout_every.
  std::string holdout;

  // File with the names of the photos kept from training, one per line; empty
  // leaves it to the options above.
  std::string holdout_list;

  // Fraction of the photos that are kept, the sharpest of each stretch of the
  // sequence.
  double keep_sharpest = 1;

  // Which frames are taken when photos come as films. Its max_megapixels is
  // decode's.
  photos::VideoFrameOptions film;

  IngestMaskOptions masks;

  Status Check() const;
};

void RegisterIngestOptions(IngestStageOptions& options,
                           pipeline::OptionTable& table);

// Writes images.json (see photos/photo_list.h), photos/ and, if there are
// masks, masks/. A photo that cannot be used is rejected with a warning; fewer
// than three usable ones are kBadInput.
std::unique_ptr<pipeline::Stage> MakeIngestStage(
    const IngestStageOptions& options);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_INGEST_INGEST_STAGE_H_
