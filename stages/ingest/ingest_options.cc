// SPDX-License-Identifier: BSD-3-Clause
// The options of stage ingest: names, help texts and ranges.

#include "stages/ingest/ingest_stage.h"

namespace freegs::stages {

Status IngestStageOptions::Check() const {
  const Status good = decode.Check();
  if (!good.ok()) return InvalidArgumentError("ingest." + good.message());
  const Status good_film = film.Check();
  if (!good_film.ok()) {
    return InvalidArgumentError("ingest." + good_film.message());
  }
  if (holdout_every < 0) {
    return InvalidArgumentError("ingest.holdout_every must not be negative");
  }
  if (!(keep_sharpest > 0 && keep_sharpest <= 1)) {
    return InvalidArgumentError("ingest.keep_sharpest must be in (0, 1]");
  }
  return Status();
}

void RegisterIngestOptions(IngestStageOptions& options,
                           pipeline::OptionTable& table) {
  table.AddSection("ingest", "Reading and choosing the photos.");
  table.Add("ingest.holdout_every",
            &options.holdout_every,
            {.help = "Every how many-th photo, from the first, is kept from "
                     "training to measure the result; 0 keeps none.",
             .min = 0});
  table.Add("ingest.holdout",
            &options.holdout,
            {.help = "Pattern of the photos kept from training, such as test_* "
                     "or val/*, or none; overrides ingest.holdout_every."});
  table.Add(
      "ingest.holdout_list",
      &options.holdout_list,
      {.help = "File with the names of the photos kept from training, one "
               "per line; overrides ingest.holdout.",
       .is_path = true});
  table.Add("ingest.keep_sharpest",
            &options.keep_sharpest,
            {.help = "Fraction of the photos to keep: the sharpest of each "
                     "stretch of the sequence, as for the frames of a video.",
             .min = 0.001,
             .max = 1});
  table.Add("ingest.video_motion",
            &options.film.motion,
            {.help = "Films: a frame is taken each time the picture has moved "
                     "by this share of its width.",
             .min = 0.001,
             .max = 1});
  table.Add(
      "ingest.video_frames",
      &options.film.max_frames,
      {.help = "Films: most frames taken from each.", .min = 3, .max = 100000});
  table.Add("ingest.use_masks",
            &options.masks.use_masks,
            {.help = "Use the masks beside the photos: masks/a.jpg.png or "
                     "masks/a.png for a.jpg; black is ignored when poses are "
                     "found and in training."});
  table.Add("ingest.masks",
            &options.masks.masks,
            {.help = "Folder of the masks, instead of masks in the photo "
                     "folder.",
             .is_path = true});
  table.Add("ingest.invert_masks",
            &options.masks.invert_masks,
            {.help = "White is ignored instead of black."});
  table.Add("ingest.background",
            &options.decode.background,
            {.help = "What shows through transparent pixels. It should be "
                     "reconstruct.background, too.",
             .choices = {"black", "white"}});
  table.Add("ingest.max_megapixels",
            &options.decode.max_megapixels,
            {.help = "Photos of more million pixels than this are not used.",
             .min = 0.001,
             .max = 1000});
}

}  // namespace freegs::stages
