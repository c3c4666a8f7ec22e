// SPDX-License-Identifier: BSD-3-Clause
// The instances of a workspace's scene, and their colours and pictures. A label
// is the instance's id - 1, or -1 for no instance; ids begin at 1.

#ifndef FREEGS_STAGES_SCENE_SCENE_INSTANCES_H_
#define FREEGS_STAGES_SCENE_SCENE_INSTANCES_H_

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <set>
#include <span>
#include <vector>

#include "core/image.h"
#include "core/status.h"
#include "semantics/field/idsf.h"
#include "semantics/instances/hierarchy.h"
#include "semantics/instances/instances.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::stages {

// kBadInput when stage bootstrap made the files in bootstrap/ from another
// model than the one that is in reconstruct/ now. Its stage.json says from
// which. A folder without that comes from elsewhere, and it may belong to any
// model. Where reconstruct/ has no model, nothing is compared.
Status CheckBootstrapOfModel(const std::filesystem::path& workspace);

// Reads bootstrap/idsf.bin. kBadInput when the file is missing or malformed, or
// when it belongs to another model: to one of another number of Gaussians, or
// as CheckBootstrapOfModel finds.
StatusOr<semantics::Idsf> ReadSemanticField(
    const std::filesystem::path& workspace, size_t num_gaussians);

// Reads the same file and returns only the label of each Gaussian.
StatusOr<std::vector<int32_t>> ReadInstanceLabels(
    const std::filesystem::path& workspace, size_t num_gaussians);

// kBadInput, which names `path`, for an id above the number of Gaussians: no
// scene has more instances.
Status CheckInstanceIds(std::span<const semantics::Instance> instances,
                        size_t num_gaussians,
                        const std::filesystem::path& path);

// Reads bootstrap/hierarchy.json. kBadInput as above.
StatusOr<semantics::Hierarchy> ReadSceneHierarchy(
    const std::filesystem::path& workspace, size_t num_gaussians);

// Returns the labels of the instances with these ids. kInvalidArgument for an
// id that no Gaussian has; the message lists the ids that exist.
StatusOr<std::set<int32_t>> LabelsOfIds(std::span<const int32_t> labels,
                                        const std::vector<int>& ids);

// Returns the model with each Gaussian in the flat colour of its label
// (semantics::PaletteColor). Geometry and opacity stay; the spherical harmonics
// are reduced to degree 0. `labels` has one label per Gaussian.
splat::GaussianModel ColorByInstance(const splat::GaussianModel& model,
                                     std::span<const int32_t> labels);

// Converts labels to the instance ids that files hold: 0 stands for no instance
// and for ids above 65535, which 16 bits cannot hold.
ImageU16 EncodeInstances(const Image<int32_t>& labels);

// Paints each pixel in the colour of its label, H x W x 3 RGB.
ImageU8 ColorInstances(const Image<int32_t>& labels);

// Mixes the photo (H x W x 3) with the colours of the labels (H x W x 1). A
// light line separates different labels, and the photo is only darkened where
// there is no instance.
ImageU8 OverlayInstances(const ImageU8& photo, const Image<int32_t>& labels);

// 255 where the pixel has this label, else 0.
ImageU8 InstanceMask(const Image<int32_t>& labels, int32_t label);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_SCENE_INSTANCES_H_
