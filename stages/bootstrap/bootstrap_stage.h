// SPDX-License-Identifier: BSD-3-Clause
// Stage bootstrap, reconstruct/ -> bootstrap/: a semantic vector and an
// instance for every Gaussian. This is phase 2 of the method.
// MakeBootstrapStage makes the stage; stages/registry/stage_registry.h shows
// who runs it. The work itself is done by semantics/field/bootstrapping.h.

#ifndef FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_STAGE_H_
#define FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_STAGE_H_

#include <cstdint>
#include <memory>

#include "pipeline/stage.h"
#include "stages/bootstrap/bootstrap_options.h"

namespace freegs::stages {

// Reads reconstruct/point_cloud.ply, undistort/ and the split from
// ingest/images.json. Writes (docs/outputs.md has the formats)
//   idsf.bin             instance and semantic vector of each Gaussian
//   instances.json       the instances: boxes, sizes, words
//   hierarchy.json       parts, things and groups that they were cut from
//   metrics.json         figures of the stage
//   instances/VIEW.png   instance ids of every view, 16-bit grey, 0 for none
//   preview/VIEW.png     a few photographs tinted by instance
// and, unless the mode is geometry,
//   decoder.bin, instance_features.json   what words are compared with
//   features/                             the CLIP features of the photographs
// Features of places are brought to the resolution of the images by the model's
// upsampler.onnx or, without one, by joint bilateral upsampling.
std::unique_ptr<pipeline::Stage> MakeBootstrapStage(
    const BootstrapStageOptions& options, uint64_t seed);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_STAGE_H_
