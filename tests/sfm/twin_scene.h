// SPDX-License-Identifier: BSD-3-Clause
// A table whose pattern repeats after half a turn, with things on it that do
// not, seen by a ring of cameras; and its model in which half of the cameras
// were put on the wrong side.

#ifndef FREEGS_TESTS_SFM_TWIN_SCENE_H_
#define FREEGS_TESTS_SFM_TWIN_SCENE_H_

#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "core/random.h"
#include "sfm/scene/reconstruction.h"
#include "tests/sfm/match_database_writer.h"
#include "tests/sfm/synthetic_model.h"

namespace freegs::sfm {

class TwinScene {
 public:
  // num_cameras around the table, evenly.
  explicit TwinScene(int num_cameras) : num_cameras_(num_cameras) {
    RandomStream random(3, 1);
    constexpr double kTurn = 2 * std::numbers::pi;
    for (int k = 0; k < 500; ++k) {
      // On the table, with its twin behind it.
      const Eigen::Vector3d on_table(
          2 * random.Uniform() - 1, 2 * random.Uniform() - 1, 0);
      const double side = kTurn * random.Uniform();
      points_.push_back({on_table, side, true});
      points_.push_back({HalfTurn(on_table), side + kTurn / 2, true});
    }
    for (int k = 0; k < 1000; ++k) {
      points_.push_back({{1.6 * random.Uniform() - 0.8,
                          1.6 * random.Uniform() - 0.8,
                          0.6 * random.Uniform()},
                         kTurn * random.Uniform(),
                         false});
    }
  }

  // The cameras from the first of the second half on are in the second group.
  bool InSecondHalf(int camera) const { return camera >= num_cameras_ / 2; }

  // glued: the second half of the cameras half a turn from where they are.
  Reconstruction Model(bool glued) const {
    Reconstruction model = SyntheticModel(1, 0);
    model.images.clear();
    std::map<uint64_t, Point3D> points;
    for (int i = 0; i < num_cameras_; ++i) {
      const bool turned = glued && InSecondHalf(i);
      PosedImage image;
      image.id = static_cast<uint32_t>(i + 1);
      image.camera_id = 1;
      image.name = PhotoName(i);
      image.cam_from_world = LookAt(Centre(i), Eigen::Vector3d::Zero());
      const Rigid3d pose = image.cam_from_world;
      if (turned) image.cam_from_world.rotation = pose.rotation * Half();
      for (size_t k = 0; k < points_.size(); ++k) {
        if (!Sees(i, k)) continue;
        Eigen::Vector3d xyz = points_[k].xyz;
        uint64_t id = 10 + k;
        if (turned) {
          xyz = HalfTurn(xyz);
          // A pattern is taken for its twin, another thing for a new one.
          id = points_[k].twin ? 10 + (k ^ 1) : 100000 + k;
        }
        Point3D& point = points[id];
        point.id = id;
        point.xyz = xyz;
        point.track.push_back(
            {image.id, static_cast<uint32_t>(image.points2d.size())});
        image.points2d.push_back(
            {*Project(model.cameras[0], pose * points_[k].xyz), id});
      }
      model.images.push_back(std::move(image));
    }
    for (auto& [id, point] : points) {
      if (point.track.size() >= 2) model.points3d.push_back(point);
    }
    RemoveDanglingReferences(&model);
    return model;
  }

  // A database of the matches that photos of this scene would have: true ones
  // where two cameras see the same, else those of twins. Both halves of
  // the ring match truly where they meet.
  void WriteMatches(const std::string& path) const {
    MatchDatabaseWriter database(path);
    for (int i = 0; i < num_cameras_; ++i) {
      for (int j = i + 1; j < num_cameras_; ++j) {
        std::vector<uint32_t> same = Matches(i, j, false);
        std::vector<uint32_t> twins = Matches(i, j, true);
        const bool planar = twins.size() > same.size();
        const std::vector<uint32_t>& data = planar ? twins : same;
        if (data.size() < 2 * 15) {
          database.Add(i + 1, j + 1, {}, 0);
        } else {
          database.Add(i + 1, j + 1, data, planar ? 6 : 2);
        }
      }
    }
  }

 private:
  struct ScenePoint {
    Eigen::Vector3d xyz;
    double side = 0;    // Azimuth from which it is seen best.
    bool twin = false;  // Number k has its twin at k ^ 1.
  };

  static Eigen::Quaterniond Half() { return {0, 0, 0, 1}; }
  static Eigen::Vector3d HalfTurn(const Eigen::Vector3d& xyz) {
    return {-xyz.x(), -xyz.y(), xyz.z()};
  }
  double Azimuth(int camera) const {
    return 2 * std::numbers::pi * camera / num_cameras_;
  }
  Eigen::Vector3d Centre(int camera) const {
    return {4 * std::cos(Azimuth(camera)), 4 * std::sin(Azimuth(camera)), 2};
  }
  // From within 50 degrees.
  bool Sees(int camera, size_t k) const {
    return std::cos(Azimuth(camera) - points_[k].side) > 0.64;
  }

  // Pairs of features, which are numbered as in Model().
  std::vector<uint32_t> Matches(int i, int j, bool twins) const {
    std::map<size_t, uint32_t> features;
    for (size_t k = 0; k < points_.size(); ++k) {
      if (Sees(i, k)) features[k] = static_cast<uint32_t>(features.size());
    }
    std::vector<uint32_t> data;
    uint32_t feature = 0;
    for (size_t k = 0; k < points_.size(); ++k) {
      if (!Sees(j, k)) continue;
      const auto it = features.find(twins ? k ^ 1 : k);
      if (it != features.end() && (!twins || points_[k].twin)) {
        data.insert(data.end(), {it->second, feature});
      }
      ++feature;
    }
    return data;
  }

  int num_cameras_;
  std::vector<ScenePoint> points_;
};

}  // namespace freegs::sfm

#endif  // FREEGS_TESTS_SFM_TWIN_SCENE_H_
