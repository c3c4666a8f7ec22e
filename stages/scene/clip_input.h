// SPDX-License-Identifier: BSD-3-Clause
// What commands give to CLIP: a model folder, words and photo files.

#ifndef FREEGS_STAGES_SCENE_CLIP_INPUT_H_
#define FREEGS_STAGES_SCENE_CLIP_INPUT_H_

#include <filesystem>
#include <memory>
#include <string>

#include "core/image.h"
#include "core/status.h"
#include "semantics/clip/opencv_clip.h"
#include "semantics/queries/instance_features.h"

namespace freegs::stages {

// The model in that folder; the one that comes with the program when empty.
// Errors as OpenCvClip::Open and FindShippedModel.
StatusOr<std::unique_ptr<semantics::OpenCvClip>> OpenClipModel(
    const std::string& folder);

// The model that a workspace's instance features were made with: in the folder
// `given`, else in the one that the features name (relative to the workspace or
// not) if it is still there, else the one that comes with the program.
// kMissingDependency also for a model of another hash than theirs.
StatusOr<std::unique_ptr<semantics::OpenCvClip>> OpenModelOfFeatures(
    const semantics::InstanceFeatures& features,
    const std::filesystem::path& workspace,
    const std::string& given);

struct UprightPhoto {
  ImageU8 pixels;    // RGB, turned as its EXIF orientation says.
  std::string hash;  // Of the file's bytes.
};

// A photograph of any size and format that ingest takes. kBadInput names the
// file and the fault.
StatusOr<UprightPhoto> ReadUprightPhoto(const std::filesystem::path& path);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_CLIP_INPUT_H_
