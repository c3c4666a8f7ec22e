// SPDX-License-Identifier: BSD-3-Clause
// Finds the similarity between two worlds that contain the same cameras.

#ifndef FREEGS_SFM_SCENE_POSE_ALIGNMENT_H_
#define FREEGS_SFM_SCENE_POSE_ALIGNMENT_H_

#include <map>
#include <string>
#include <vector>

#include "core/rigid3d.h"
#include "core/status.h"

namespace freegs::sfm {

// cam_from_world by photo name.
using NamedPoses = std::map<std::string, Rigid3d>;

struct PoseAlignment {
  Sim3d target_from_source;

  // What is left between the two poses of a camera after alignment.
  struct Residual {
    std::string name;
    double rotation_deg = 0;  // Angle between the two orientations.
    double centre = 0;        // Distance of the two centres, in target units.
  };

  // One for each camera that is in both sets, by name.
  std::vector<Residual> residuals;
  double median_rotation_deg = 0;
  double max_rotation_deg = 0;
  double median_centre = 0;
  double max_centre = 0;
};

// Aligns the cameras that both sets name:
//
//   FREEGS_ASSIGN_OR_RETURN(const PoseAlignment alignment,
//                           AlignPoses(estimated, truth));
//   const Eigen::Vector3d x_truth = alignment.target_from_source * x_estimated;
//
// The similarity x_target = scale * R * x_source + t minimises the sum of the
// squared distances between the camera centres (Umeyama, "Least-squares
// estimation of transformation parameters between two point patterns", PAMI
// 1991). Centres close to a line hardly determine the roll about it. So R also
// takes the relative rotations of the cameras into account, as far as the noise
// of the centres leaves it open. Orientations that contradict the centres, such
// as those of another convention of axes, are left out. Returns kBadInput with
// fewer than three common names, and when the centres coincide or are not
// finite.
StatusOr<PoseAlignment> AlignPoses(const NamedPoses& source,
                                   const NamedPoses& target);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_POSE_ALIGNMENT_H_
