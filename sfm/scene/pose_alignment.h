// SPDX-License-Identifier: BSD-3-Clause
// The similarity between two worlds that hold the same cameras.

#ifndef FREEGS_SFM_SCENE_POSE_ALIGNMENT_H_
#define FREEGS_SFM_SCENE_POSE_ALIGNMENT_H_

#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/rigid3d.h"
#include "core/status.h"

namespace freegs::sfm {

// cam_from_world by photo name.
using NamedPoses = std::map<std::string, Rigid3d>;

struct PoseAlignment {
  Sim3d target_from_source;

  // Of each camera in both sets, by name, after alignment:
  struct Residual {
    std::string name;
    double rotation_deg = 0;  // Angle between the two orientations.
    double centre = 0;        // Distance of the centres, in target units.
  };
  std::vector<Residual> residuals;
  double median_rotation_deg = 0;
  double max_rotation_deg = 0;
  double median_centre = 0;
  double max_centre = 0;
};

// x_target = scale * R * x_source + t with the least sum of squared distances
// (Umeyama, "Least-squares estimation of transformation parameters between two
// point patterns", PAMI 1991). points: equal count, at least 2. The rotation is
// not determined when the points lie on a line; kBadInput when they coincide.
StatusOr<Sim3d> AlignPoints(const std::vector<Eigen::Vector3d>& source,
                            const std::vector<Eigen::Vector3d>& target);

// Aligns the cameras that both sets name: by their centres, or, when those lie
// close to a line, with the mean of the relative rotations and then scale and
// translation from the centres. kBadInput with fewer than three common names,
// or coinciding centres.
StatusOr<PoseAlignment> AlignPoses(const NamedPoses& source,
                                   const NamedPoses& target);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_POSE_ALIGNMENT_H_
