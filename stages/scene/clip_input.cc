// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/clip_input.h"

#include <cstdint>
#include <system_error>
#include <utility>

#include "core/io/files.h"
#include "photos/photo_decode.h"
#include "stages/scene/shipped_model.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxPhotoBytes = uint64_t{1} << 30;

}  // namespace

StatusOr<fs::path> ClipModelFolder(const std::string& folder) {
  if (folder.empty()) return FindShippedModel();
  return fs::path(folder);
}

StatusOr<std::unique_ptr<semantics::OpenCvClip>> OpenClipModel(
    const std::string& folder) {
  FREEGS_ASSIGN_OR_RETURN(const fs::path model, ClipModelFolder(folder));
  return semantics::OpenCvClip::Open(model);
}

StatusOr<std::unique_ptr<semantics::OpenCvClip>> OpenModelOfFeatures(
    const semantics::InstanceFeatures& features,
    const fs::path& workspace,
    const std::string& given) {
  std::string folder = given;
  std::error_code error;
  const fs::path named = workspace / features.model;
  if (folder.empty() && !features.model.empty() &&
      fs::exists(named / "model.json", error)) {
    folder = named.string();
  }
  FREEGS_ASSIGN_OR_RETURN(std::unique_ptr<semantics::OpenCvClip> encoder,
                          OpenClipModel(folder));
  if (encoder->model_hash() != features.model_hash) {
    return MissingDependencyError(
        (folder.empty() ? "the CLIP model that comes with the program"
                        : folder) +
        ": is another model (" + encoder->model_hash() +
        ") than the one of the scene's features (" + features.model +
        ", hash " + features.model_hash +
        "); name its folder with --model, or run stage bootstrap again");
  }
  return encoder;
}

StatusOr<UprightPhoto> ReadUprightPhoto(const fs::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string bytes,
                          ReadFile(path, kMaxPhotoBytes));
  StatusOr<UprightPhoto> photo = DecodeUprightPhoto(bytes);
  if (!photo.ok()) return photo.status().Annotated(path.string());
  return photo;
}

StatusOr<UprightPhoto> DecodeUprightPhoto(std::string_view bytes,
                                          double max_megapixels) {
  photos::PhotoDecodeOptions options;
  options.max_megapixels = max_megapixels;
  options.min_side = 1;
  options.background = "white";
  FREEGS_ASSIGN_OR_RETURN(const photos::PhotoHeader header,
                          photos::ParsePhotoHeader(bytes));
  FREEGS_RETURN_IF_ERROR(photos::CheckHeader(header, options));
  FREEGS_ASSIGN_OR_RETURN(ImageU8 pixels,
                          photos::DecodePhoto(bytes, header, options));
  return UprightPhoto{std::move(pixels), HashBytes(bytes)};
}

}  // namespace freegs::stages
