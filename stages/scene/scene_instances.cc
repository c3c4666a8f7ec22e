// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/scene_instances.h"

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include "core/text.h"
#include "pipeline/fingerprint.h"
#include "pipeline/stage_record.h"
#include "pipeline/workspace.h"
#include "semantics/instances/palette.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// The share of the instance's colour in an overlay.
constexpr float kTint = 0.6f;
constexpr float kDarkened = 0.45f;  // Brightness where there is no instance.
constexpr uint8_t kBorder = 245;

constexpr size_t kShownIds = 50;  // In a message.

}  // namespace

Status CheckBootstrapOfModel(const fs::path& workspace) {
  const std::string input = "reconstruct/point_cloud.ply";
  const StatusOr<pipeline::StageRecord> record =
      pipeline::ReadStageRecord(workspace / "bootstrap");
  if (!record.ok()) return Status();
  const auto then = record->fingerprint.inputs.find(input);
  if (then == record->fingerprint.inputs.end()) return Status();
  // A new hash is not saved, because a run may be saving its own ones now.
  pipeline::FingerprintCache cache(workspace,
                                   pipeline::FingerprintCachePath(workspace));
  const pipeline::InputFingerprint now = cache.Hash(workspace / input);
  if (now.missing() || now.hash == then->second.hash) return Status();
  return BadInputError((workspace / "bootstrap").string() +
                       ": is of another reconstruction than " + input +
                       " is now; run stage bootstrap again");
}

StatusOr<semantics::Idsf> ReadSemanticField(const fs::path& workspace,
                                            size_t num_gaussians) {
  const fs::path path = workspace / "bootstrap" / "idsf.bin";
  std::error_code error;
  if (!fs::exists(path, error)) {
    return BadInputError(path.string() +
                         ": no such file; run stage bootstrap first");
  }
  FREEGS_ASSIGN_OR_RETURN(semantics::Idsf idsf, semantics::ReadIdsf(path));
  if (idsf.instances.size() != num_gaussians) {
    return BadInputError(path.string() + ": is of a scene with " +
                         std::to_string(idsf.instances.size()) +
                         " Gaussians, not " + std::to_string(num_gaussians) +
                         "; run stage bootstrap again");
  }
  FREEGS_RETURN_IF_ERROR(CheckBootstrapOfModel(workspace));
  return idsf;
}

StatusOr<std::vector<int32_t>> ReadInstanceLabels(const fs::path& workspace,
                                                  size_t num_gaussians) {
  FREEGS_ASSIGN_OR_RETURN(semantics::Idsf idsf,
                          ReadSemanticField(workspace, num_gaussians));
  return std::move(idsf.instances);
}

Status CheckInstanceIds(std::span<const semantics::Instance> instances,
                        size_t num_gaussians,
                        const fs::path& path) {
  for (const semantics::Instance& instance : instances) {
    if (static_cast<size_t>(instance.id) <= num_gaussians) continue;
    return BadInputError(path.string() + ": has an instance " +
                         std::to_string(instance.id) + " of a scene with " +
                         std::to_string(num_gaussians) +
                         " Gaussians; run stage bootstrap again");
  }
  return Status();
}

StatusOr<semantics::Hierarchy> ReadSceneHierarchy(const fs::path& workspace,
                                                  size_t num_gaussians) {
  const fs::path path = workspace / "bootstrap" / "hierarchy.json";
  std::error_code error;
  if (!fs::exists(path, error)) {
    return BadInputError(path.string() +
                         ": no such file; run stage bootstrap with "
                         "bootstrap.clustering evidence to have parts and "
                         "wholes");
  }
  FREEGS_RETURN_IF_ERROR(CheckBootstrapOfModel(workspace));
  return semantics::ReadHierarchy(path, num_gaussians);
}

StatusOr<std::set<int32_t>> LabelsOfIds(std::span<const int32_t> labels,
                                        const std::vector<int>& ids) {
  const std::set<int32_t> present(labels.begin(), labels.end());
  std::set<int32_t> asked;
  for (const int id : ids) {
    if (id < 1 || !present.contains(id - 1)) {
      std::vector<std::string> known;
      for (const int32_t label : present) {
        if (label >= 0) known.push_back(std::to_string(label + 1));
      }
      return InvalidArgumentError(
          "there is no instance " + std::to_string(id) + "; there are " +
          (known.empty() ? "none" : SomeNames(known, kShownIds)));
    }
    asked.insert(id - 1);
  }
  return asked;
}

splat::GaussianModel ColorByInstance(const splat::GaussianModel& model,
                                     std::span<const int32_t> labels) {
  splat::GaussianModel colored = model;
  colored.SetShDegree(0);
  for (size_t i = 0; i < colored.size(); ++i) {
    const std::array<uint8_t, 3> color = semantics::PaletteColor(labels[i]);
    for (size_t c = 0; c < 3; ++c) {
      colored.sh_dc[3 * i + c] =
          (static_cast<float>(color[c]) / 255.0f - 0.5f) / splat::kShC0;
    }
  }
  return colored;
}

ImageU16 EncodeInstances(const Image<int32_t>& labels) {
  ImageU16 ids(labels.width(), labels.height(), 1);
  std::transform(labels.data(),
                 labels.data() + labels.size(),
                 ids.data(),
                 [](int32_t label) {
                   return label >= 0 && label < 65535
                              ? static_cast<uint16_t>(label + 1)
                              : uint16_t{0};
                 });
  return ids;
}

ImageU8 ColorInstances(const Image<int32_t>& labels) {
  ImageU8 colors(labels.width(), labels.height(), 3);
  for (size_t k = 0; k < labels.num_pixels(); ++k) {
    const std::array<uint8_t, 3> color =
        semantics::PaletteColor(labels.data()[k]);
    std::copy(color.begin(), color.end(), colors.data() + 3 * k);
  }
  return colors;
}

ImageU8 OverlayInstances(const ImageU8& photo, const Image<int32_t>& labels) {
  ImageU8 overlay(photo.width(), photo.height(), 3);
  for (int y = 0; y < photo.height(); ++y) {
    for (int x = 0; x < photo.width(); ++x) {
      const int32_t label = labels(x, y);
      const bool border =
          (x + 1 < photo.width() && labels(x + 1, y) != label) ||
          (y + 1 < photo.height() && labels(x, y + 1) != label);
      const std::array<uint8_t, 3> color = semantics::PaletteColor(label);
      for (int c = 0; c < 3; ++c) {
        const auto value = static_cast<float>(photo(x, y, c));
        const float mixed =
            label < 0
                ? kDarkened * value
                : (1 - kTint) * value +
                      kTint * static_cast<float>(color[static_cast<size_t>(c)]);
        overlay(x, y, c) =
            border ? kBorder : static_cast<uint8_t>(mixed + 0.5f);
      }
    }
  }
  return overlay;
}

ImageU8 InstanceMask(const Image<int32_t>& labels, int32_t label) {
  ImageU8 mask(labels.width(), labels.height(), 1);
  std::transform(labels.data(),
                 labels.data() + labels.size(),
                 mask.data(),
                 [label](int32_t value) {
                   return value == label ? uint8_t{255} : uint8_t{0};
                 });
  return mask;
}

}  // namespace freegs::stages
