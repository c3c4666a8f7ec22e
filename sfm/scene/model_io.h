// SPDX-License-Identifier: BSD-3-Clause
// Sparse reconstructions in COLMAP's model folders, binary or text.

#ifndef FREEGS_SFM_SCENE_MODEL_IO_H_
#define FREEGS_SFM_SCENE_MODEL_IO_H_

#include <filesystem>
#include <optional>

#include "core/status.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

enum class ModelFormat { kBinary, kText };

// The format of the model in `folder`: binary when cameras.bin, images.bin and
// points3D.bin are there, else text when the three .txt files are; nothing
// otherwise. Files of newer releases (rigs, frames) are ignored: the poses in
// the images files stand for themselves.
std::optional<ModelFormat> DetectModelFormat(
    const std::filesystem::path& folder);

// Reads the model in `folder`. kBadInput names the file and the fault: missing,
// truncated, inconsistent (see CheckReconstruction), or trailing bytes.
StatusOr<Reconstruction> ReadModel(const std::filesystem::path& folder);

// Writes the three files, each atomically, into `folder`, which is created. A
// model read from COLMAP's binary files is written back byte for byte.
Status WriteModel(const std::filesystem::path& folder,
                  const Reconstruction& model,
                  ModelFormat format = ModelFormat::kBinary);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_MODEL_IO_H_
