// SPDX-License-Identifier: BSD-3-Clause
// The frame in which stages and commands compute. Files of a workspace are in
// the world frame of the camera poses, which may count in any unit and from any
// place. Everything in memory is in the frame of splat::ModelFrame, so that
// results do not depend on the unit or the place; what is written is brought
// back.

#ifndef FREEGS_STAGES_SCENE_WORKING_FRAME_H_
#define FREEGS_STAGES_SCENE_WORKING_FRAME_H_

#include <span>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "semantics/instances/instances.h"
#include "sfm/scene/reconstruction.h"
#include "splat/render/renderer.h"
#include "splat/scene/model_frame.h"

namespace freegs::stages {

// Chooses the frame from what the views see of the points of `sparse`: the
// origin is the median of their positions, axis by axis, and their median depth
// is splat::kTypicalDepth. Where no view sees a point, sfm::EstimateFocus takes
// their place. `views` are those of `sparse`, in the world frame.
splat::ModelFrame ChooseFrame(const sfm::Reconstruction& sparse,
                              std::span<const View> views);

// Brings the poses and points of a reconstruction into the frame, rounded to
// multiples of 2^-18.
void MoveToFrame(const splat::ModelFrame& frame, sfm::Reconstruction* sparse);

// Brings the position and the boxes of an instance back into the world.
semantics::Instance InWorld(const splat::ModelFrame& frame,
                            semantics::Instance instance);

// What a user should know about the positions in the PLY and .splat files of a
// scene that is far from the origin of its world; empty for other scenes.
std::string FarAwayNote(const splat::ModelFrame& frame);

// kUnusableResult when none of the views shows any Gaussian.
Status CheckVisible(const splat::GaussianModel& model,
                    std::span<const View> views,
                    const splat::RenderOptions& render,
                    ThreadPool& pool);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_WORKING_FRAME_H_
