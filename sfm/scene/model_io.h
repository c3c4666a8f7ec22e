// SPDX-License-Identifier: BSD-3-Clause
// Reads and writes reconstructions as COLMAP's model folders, binary or text.

#ifndef FREEGS_SFM_SCENE_MODEL_IO_H_
#define FREEGS_SFM_SCENE_MODEL_IO_H_

#include <filesystem>
#include <optional>

#include "core/status.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

enum class ModelFormat { kBinary, kText };

// Returns the format of the model in `folder`: binary when cameras.bin,
// images.bin and points3D.bin exist, else text when the three .txt files exist,
// else nothing. The rigs and frames files of newer releases are ignored,
// because the images file has the poses.
std::optional<ModelFormat> DetectModelFormat(
    const std::filesystem::path& folder);

// Reads the model in `folder`. Returns kBadInput, with the name of the file and
// the fault, when a file is missing, truncated, has bytes left over, or is
// inconsistent (see CheckReconstruction), or when a camera's model is not
// supported (see FindStoredCameraModel).
StatusOr<Reconstruction> ReadModel(const std::filesystem::path& folder);

// Reads the model like ReadModel, but without CheckReconstruction.
StatusOr<Reconstruction> ReadModelUnchecked(
    const std::filesystem::path& folder);

// Writes the three files, each atomically, into `folder`, which is created if
// it is missing. A model that was read from COLMAP's binary files is written
// back byte for byte, if its cameras are of models that COLMAP 3.8 has.
Status WriteModel(const std::filesystem::path& folder,
                  const Reconstruction& model,
                  ModelFormat format = ModelFormat::kBinary);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_MODEL_IO_H_
