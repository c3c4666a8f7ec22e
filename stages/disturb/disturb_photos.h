// SPDX-License-Identifier: BSD-3-Clause
// Writes a folder of photographs anew, disturbed.

#ifndef FREEGS_STAGES_DISTURB_DISTURB_PHOTOS_H_
#define FREEGS_STAGES_DISTURB_DISTURB_PHOTOS_H_

#include <cstdint>
#include <filesystem>

#include "core/cancellation.h"
#include "core/status.h"
#include "stages/disturb/disturbance.h"

namespace freegs::stages {

// Writes the photographs of folder `images`, and the masks in its folder
// `masks`, into the new folder `out`. Photographs keep their names, because the
// truth is known by these. When they are shuffled each goes into a folder of
// its own, whose number is its place in the new order ("0003/a.jpg"): stage
// ingest goes by folders first, and the truth by the name without folders.
//
// EXIF is kept. A JPEG whose pixels change is written with quality 95, a PNG as
// PNG. Compressed photographs are JPEGs whatever they are called, because the
// content decides. A TIFF is copied where neither its pixels nor its EXIF
// change, and is kBadInput otherwise; a transparent PNG, where its pixels do
// not change.
//
// Files that stage ingest rejects by their headers are no photographs here:
// they are copied as they are, and not counted or chosen from. So is one whose
// pixels are damaged where these would change. Files that cannot be read are
// left out.
//
// The same seed gives the same files. kBadInput for films, for a folder without
// photographs, when no photograph would be left, and when nothing would change:
// `drop` (but of a share of 0) and `views` that leave out no photograph, and a
// focal length that is not read (FocalLengthPixels).
// kInterrupted when cancelled, which leaves some photographs in `out`.
Status DisturbPhotos(const Disturbance& disturbance,
                     const std::filesystem::path& images,
                     const std::filesystem::path& out,
                     uint64_t seed,
                     const CancellationToken* cancellation = nullptr);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_DISTURB_DISTURB_PHOTOS_H_
