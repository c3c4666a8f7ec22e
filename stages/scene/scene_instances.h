// SPDX-License-Identifier: BSD-3-Clause
// The instances of a workspace's scene, as colours and pictures. Labels are -1
// for none, else instance id - 1.

#ifndef FREEGS_STAGES_SCENE_SCENE_INSTANCES_H_
#define FREEGS_STAGES_SCENE_SCENE_INSTANCES_H_

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/image.h"
#include "core/status.h"
#include "semantics/field/idsf.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::stages {

// bootstrap/idsf.bin. kBadInput when there is none, or when it belongs to
// another model: not of num_gaussians.
StatusOr<semantics::Idsf> ReadSemanticField(
    const std::filesystem::path& workspace, size_t num_gaussians);

// Only the label of each Gaussian.
StatusOr<std::vector<int32_t>> ReadInstanceLabels(
    const std::filesystem::path& workspace, size_t num_gaussians);

// The Gaussians of the instances with these ids, or (`without`) all others,
// those of no instance among them. kInvalidArgument, naming the ids there are,
// for an id that no Gaussian has.
StatusOr<splat::GaussianModel> SelectInstances(
    const splat::GaussianModel& model,
    std::span<const int32_t> labels,
    const std::vector<int>& ids,
    bool without);

// The model with every Gaussian in the flat colour of its label
// (semantics::PaletteColor): same geometry and opacity, spherical harmonics of
// degree 0. labels: one per Gaussian.
splat::GaussianModel ColorByInstance(const splat::GaussianModel& model,
                                     std::span<const int32_t> labels);

// Label images as files carry them: instance ids, 0 for none and for ids beyond
// 65535.
ImageU16 EncodeInstances(const Image<int32_t>& labels);

// H x W x 3: each pixel in its label's colour.
ImageU8 ColorInstances(const Image<int32_t>& labels);

// The photo mixed with the labels' colours, with a light line where two labels
// meet. The photo is only darkened where there is no instance. Both of the same
// size.
ImageU8 OverlayInstances(const ImageU8& photo, const Image<int32_t>& labels);

// 255 where the image has `label`, else 0.
ImageU8 InstanceMask(const Image<int32_t>& labels, int32_t label);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_SCENE_INSTANCES_H_
