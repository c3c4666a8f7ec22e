// SPDX-License-Identifier: BSD-3-Clause
// Opens what stage bootstrap and the commands give to CLIP: model folders and
// photo files.
//
//   FREEGS_ASSIGN_OR_RETURN(const auto encoder, OpenClipModel(""));
//   FREEGS_ASSIGN_OR_RETURN(const auto text, encoder->EncodeText("red apple"));

#ifndef FREEGS_STAGES_SCENE_CLIP_INPUT_H_
#define FREEGS_STAGES_SCENE_CLIP_INPUT_H_

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "core/image.h"
#include "core/status.h"
#include "semantics/clip/opencv_clip.h"
#include "semantics/queries/instance_features.h"

namespace freegs::stages {

// Returns `folder`, or that of the model that comes with the program when
// `folder` is empty. The errors are those of FindShippedModel.
StatusOr<std::filesystem::path> ClipModelFolder(const std::string& folder);

// Opens the model in ClipModelFolder(folder). The errors are those of
// OpenCvClip::Open and FindShippedModel.
StatusOr<std::unique_ptr<semantics::OpenCvClip>> OpenClipModel(
    const std::string& folder);

// Opens the model that a workspace's instance features were made with. It is
// taken from the folder `given`; when that is empty, from the folder that the
// features name (absolute or relative to the workspace) if it still exists;
// else it is the model that comes with the program. kMissingDependency when
// there is no model or its hash differs from the one in the features.
StatusOr<std::unique_ptr<semantics::OpenCvClip>> OpenModelOfFeatures(
    const semantics::InstanceFeatures& features,
    const std::filesystem::path& workspace,
    const std::string& given);

struct UprightPhoto {
  ImageU8 pixels;    // H x W x 3, RGB, after the EXIF orientation is applied.
  std::string hash;  // HashBytes of the file's content.
};

// Reads a photograph of any size in a format that stage ingest accepts.
// kBadInput names the file and the fault.
StatusOr<UprightPhoto> ReadUprightPhoto(const std::filesystem::path& path);

// Reads a photograph like ReadUprightPhoto from the bytes of a file, of at most
// so many millions of pixels. Messages do not name the file.
StatusOr<UprightPhoto> DecodeUprightPhoto(std::string_view bytes,
                                          double max_megapixels = 400);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_CLIP_INPUT_H_
