// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/mapping/place_comparison.h"

#include <algorithm>
#include <map>
#include <numbers>
#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/quantile.h"
#include "core/rigid3d.h"

namespace freegs::sfm {
namespace {

constexpr double kMaxTurn = 5 * std::numbers::pi / 180;
constexpr double kMaxShareOfSize = 0.05;
constexpr size_t kMinCommon = 3;
constexpr double kWitnessShare = 0.8;

// A camera of both models.
struct CommonCamera {
  std::string name;
  Rigid3d here;  // cam_from_world.
  Rigid3d there;
  Eigen::Vector3d centre_here;
  Eigen::Vector3d centre_there;
};

// Returns the cameras of photos that both models have, by ascending name.
std::vector<CommonCamera> CommonCameras(const Reconstruction& model,
                                        const Reconstruction& other) {
  std::map<std::string, Rigid3d> poses;
  for (const PosedImage& image : other.images) {
    poses[image.name] = image.cam_from_world;
  }
  std::map<std::string, CommonCamera> common;
  for (const PosedImage& image : model.images) {
    const auto found = poses.find(image.name);
    if (found == poses.end()) continue;
    common[image.name] = {image.name,
                          image.cam_from_world,
                          found->second,
                          CameraCentre(image.cam_from_world),
                          CameraCentre(found->second)};
  }
  std::vector<CommonCamera> cameras;
  for (auto& [name, camera] : common) cameras.push_back(std::move(camera));
  return cameras;
}

double SizeThere(const std::vector<CommonCamera>& cameras) {
  Eigen::Vector3d middle;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const CommonCamera& camera : cameras) {
      values.push_back(camera.centre_there[axis]);
    }
    middle[axis] = Median(std::move(values));
  }
  std::vector<double> distances;
  for (const CommonCamera& camera : cameras) {
    distances.push_back((camera.centre_there - middle).norm());
  }
  return NearestQuantile(std::move(distances), 0.75);
}

// Which cameras `there_from_here` puts where they are there.
struct Agreement {
  std::vector<bool> alike;
  size_t count = 0;
  double distances = 0;  // Sum over these cameras.

  bool IsBetterThan(const Agreement& other) const {
    return count != other.count ? count > other.count
                                : distances < other.distances;
  }
};

Agreement Agree(const std::vector<CommonCamera>& cameras,
                const Sim3d& there_from_here,
                double max_distance) {
  Agreement agreement;
  for (const CommonCamera& camera : cameras) {
    const double distance =
        (there_from_here * camera.centre_here - camera.centre_there).norm();
    const Eigen::Quaterniond expected =
        camera.here.rotation * there_from_here.rotation.conjugate();
    const bool alike =
        distance <= max_distance &&
        expected.angularDistance(camera.there.rotation) <= kMaxTurn;
    agreement.alike.push_back(alike);
    if (!alike) continue;
    ++agreement.count;
    agreement.distances += distance;
  }
  return agreement;
}

struct Votes {
  size_t agree = 0;
  size_t disagree = 0;
  bool witness_disagrees = false;

  bool Uncertain() const { return witness_disagrees || disagree > agree; }
};

// What the other models say about the photos of one.
struct Opinions {
  std::map<std::string, Votes> votes;  // By name.
  bool witnessed = false;

  size_t Confirmed() const {
    return static_cast<size_t>(
        std::count_if(votes.begin(), votes.end(), [](const auto& photo) {
          return photo.second.agree > 0 && !photo.second.Uncertain();
        }));
  }
  size_t Agreeing() const {
    size_t sum = 0;
    for (const auto& [name, vote] : votes) sum += vote.agree;
    return sum;
  }
};

Opinions AskOthers(const std::vector<Reconstruction>& models, size_t index) {
  Opinions opinions;
  for (const PosedImage& image : models[index].images) {
    opinions.votes[image.name] = {};
  }
  for (size_t other = 0; other < models.size(); ++other) {
    if (other == index) continue;
    const PlaceComparison places = ComparePlaces(models[index], models[other]);
    const bool witness =
        static_cast<double>(places.alike.size()) >=
        kWitnessShare * static_cast<double>(models[index].images.size());
    opinions.witnessed |= witness;
    for (const std::string& name : places.alike) ++opinions.votes[name].agree;
    for (const std::string& name : places.elsewhere) {
      Votes& votes = opinions.votes[name];
      ++votes.disagree;
      votes.witness_disagrees |= witness;
    }
  }
  return opinions;
}

}  // namespace

PlaceComparison ComparePlaces(const Reconstruction& model,
                              const Reconstruction& other) {
  const std::vector<CommonCamera> cameras = CommonCameras(model, other);
  if (cameras.size() < kMinCommon) return {};
  const double max_distance = kMaxShareOfSize * SizeThere(cameras);
  Agreement best;
  for (const CommonCamera& anchor : cameras) {
    Sim3d there_from_here;
    there_from_here.rotation =
        (anchor.there.rotation.conjugate() * anchor.here.rotation).normalized();
    for (const CommonCamera& second : cameras) {
      const double here = (second.centre_here - anchor.centre_here).norm();
      const double there = (second.centre_there - anchor.centre_there).norm();
      if (!(here > 0 && there > 0)) continue;
      there_from_here.scale = there / here;
      there_from_here.translation = Eigen::Vector3d::Zero();
      there_from_here.translation =
          anchor.centre_there - there_from_here * anchor.centre_here;
      Agreement agreement = Agree(cameras, there_from_here, max_distance);
      if (agreement.IsBetterThan(best)) best = std::move(agreement);
    }
  }
  PlaceComparison result;
  for (size_t i = 0; i < best.alike.size(); ++i) {
    (best.alike[i] ? result.alike : result.elsewhere)
        .push_back(cameras[i].name);
  }
  return result;
}

Consensus FindConsensus(const std::vector<Reconstruction>& models) {
  Consensus consensus;
  Opinions best = AskOthers(models, 0);
  for (size_t i = 1; i < models.size(); ++i) {
    Opinions opinions = AskOthers(models, i);
    if (std::pair(opinions.Confirmed(), opinions.Agreeing()) <=
        std::pair(best.Confirmed(), best.Agreeing())) {
      continue;
    }
    consensus.best = i;
    best = std::move(opinions);
  }
  for (const auto& [name, votes] : best.votes) {
    if (votes.Uncertain()) consensus.uncertain.push_back(name);
  }
  consensus.witnessed = best.witnessed;
  return consensus;
}

}  // namespace freegs::sfm
