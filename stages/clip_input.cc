// SPDX-License-Identifier: BSD-3-Clause

#include "stages/clip_input.h"

#include <cstdint>
#include <utility>

#include "core/files.h"
#include "sfm/photo_decode.h"
#include "stages/shipped_model.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxFileBytes = uint64_t{1} << 30;

}  // namespace

StatusOr<std::unique_ptr<semantics::OpenCvClip>> OpenClipModel(
    const std::string& folder) {
  if (!folder.empty()) return semantics::OpenCvClip::Open(folder);
  FREEGS_ASSIGN_OR_RETURN(const fs::path shipped, FindShippedModel());
  return semantics::OpenCvClip::Open(shipped);
}

StatusOr<UprightPhoto> ReadUprightPhoto(const fs::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string bytes,
                          ReadFile(path, kMaxFileBytes));
  sfm::PhotoDecodeOptions options;
  options.min_side = 1;
  const StatusOr<sfm::PhotoHeader> header = sfm::ParsePhotoHeader(bytes);
  if (!header.ok()) return header.status().Annotated(path.string());
  const Status good = sfm::CheckHeader(*header, options);
  if (!good.ok()) return good.Annotated(path.string());
  StatusOr<ImageU8> pixels = sfm::DecodePhoto(bytes, *header, options);
  if (!pixels.ok()) return pixels.status().Annotated(path.string());
  return UprightPhoto{*std::move(pixels), HashBytes(bytes)};
}

}  // namespace freegs::stages
