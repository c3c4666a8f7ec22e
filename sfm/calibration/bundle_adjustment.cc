// SPDX-License-Identifier: BSD-3-Clause
// Bundle adjustment with Ceres.

#include "sfm/calibration/bundle_adjustment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include "sfm/scene/camera_projection.h"

namespace freegs::sfm {
namespace {

// Scale of the Cauchy loss: residuals well above it count less.
constexpr double kLossScalePx = 1.0;

// With more images the poses are solved for iteratively. An exact solution for
// 1000 images takes 120 seconds a step, and the adjustment ends at the same
// cost without it.
constexpr size_t kMaxDenseImages = 200;

// An image's pose as Ceres sees it: x_cam = exp(delta) * start * x + t, where
// delta is an angle-axis vector that begins at 0.
struct PoseBlock {
  Eigen::Matrix3d start = Eigen::Matrix3d::Identity();
  std::array<double, 6> values = {};  // delta, t.
  size_t observations = 0;
};

// A camera's parameters without the principal point: focal, distortion.
struct LensBlock {
  std::array<double, 6> values = {};
  Eigen::Vector2d principal = Eigen::Vector2d::Zero();
};

struct Observation {
  size_t image = 0;
  size_t camera = 0;
  size_t point = 0;
  Eigen::Vector2d xy = Eigen::Vector2d::Zero();
};

template <CameraModel kModel>
struct ReprojectionError {
  const Eigen::Matrix3d* start;
  Eigen::Vector2d principal;
  Eigen::Vector2d observed;

  template <typename T>
  bool operator()(const T* pose,
                  const T* point,
                  const T* lens,
                  T* residual) const {
    constexpr int kNumFocal = GetCameraModel(kModel).num_focal;
    T turned[3];
    for (int i = 0; i < 3; ++i) {
      turned[i] = point[0] * (*start)(i, 0) + point[1] * (*start)(i, 1) +
                  point[2] * (*start)(i, 2);
    }
    T in_camera[3];
    ceres::AngleAxisRotatePoint(pose, turned, in_camera);
    for (int i = 0; i < 3; ++i) in_camera[i] += pose[3 + i];
    if (!(in_camera[2] > std::numeric_limits<double>::epsilon())) {
      // A step that puts points behind cameras costs much, and is undone.
      constexpr double kBehindPx = 100;
      residual[0] = residual[1] = T(kBehindPx);
      return true;
    }
    const Vector2<T> uv = Distort<T>(
        kModel,
        lens + kNumFocal,
        Vector2<T>(in_camera[0] / in_camera[2], in_camera[1] / in_camera[2]));
    residual[0] = lens[0] * uv.x() + (principal.x() - observed.x());
    residual[1] = lens[kNumFocal - 1] * uv.y() + (principal.y() - observed.y());
    return true;
  }
};

template <CameraModel kModel, int kLensSize>
ceres::CostFunction* MakeCost(const PoseBlock& pose,
                              const LensBlock& lens,
                              const Eigen::Vector2d& observed) {
  using Error = ReprojectionError<kModel>;
  return new ceres::AutoDiffCostFunction<Error, 2, 6, 3, kLensSize>(
      new Error{&pose.start, lens.principal, observed});
}

ceres::CostFunction* MakeCost(CameraModel model,
                              const PoseBlock& pose,
                              const LensBlock& lens,
                              const Eigen::Vector2d& observed) {
  switch (model) {
    case CameraModel::kSimplePinhole:
      return MakeCost<CameraModel::kSimplePinhole, 1>(pose, lens, observed);
    case CameraModel::kPinhole:
      return MakeCost<CameraModel::kPinhole, 2>(pose, lens, observed);
    case CameraModel::kSimpleRadial:
      return MakeCost<CameraModel::kSimpleRadial, 2>(pose, lens, observed);
    case CameraModel::kRadial:
      return MakeCost<CameraModel::kRadial, 3>(pose, lens, observed);
    case CameraModel::kOpenCv:
      return MakeCost<CameraModel::kOpenCv, 6>(pose, lens, observed);
    case CameraModel::kOpenCvFisheye:
      return MakeCost<CameraModel::kOpenCvFisheye, 6>(pose, lens, observed);
    default:
      return nullptr;  // See CanAdjust.
  }
}

// Everything that is adjusted, as Ceres wants it. Ceres orders the blocks of a
// group by address: one array for each kind keeps that the same in every run.
struct Blocks {
  std::vector<PoseBlock> poses;               // By image.
  std::vector<LensBlock> lenses;              // By camera.
  std::vector<std::array<double, 3>> points;  // By point.
  std::vector<Observation> observations;      // Those of points seen twice.
};

Blocks MakeBlocks(const Reconstruction& model) {
  const auto image_index = IndexImages(model);
  const auto camera_index = IndexCameras(model);
  Blocks blocks;
  for (const PosedImage& image : model.images) {
    PoseBlock& block = blocks.poses.emplace_back();
    block.start = image.cam_from_world.rotation.toRotationMatrix();
    const Eigen::Vector3d& t = image.cam_from_world.translation;
    block.values = {0, 0, 0, t.x(), t.y(), t.z()};
  }
  for (const Camera& camera : model.cameras) {
    LensBlock& block = blocks.lenses.emplace_back();
    const int num_focal = GetCameraModel(camera.model).num_focal;
    block.principal = {camera.PrincipalX(), camera.PrincipalY()};
    std::copy_n(camera.params.begin(), num_focal, block.values.begin());
    std::copy(camera.Distortion().begin(),
              camera.Distortion().end(),
              block.values.begin() + num_focal);
  }
  for (size_t p = 0; p < model.points3d.size(); ++p) {
    const Point3D& point = model.points3d[p];
    blocks.points.push_back({point.xyz.x(), point.xyz.y(), point.xyz.z()});
    const size_t first = blocks.observations.size();
    for (const TrackElement& element : point.track) {
      const auto it = image_index.find(element.image_id);
      if (it == image_index.end()) continue;
      const PosedImage& image = model.images[it->second];
      if (element.point2d_index >= image.points2d.size()) continue;
      const size_t camera = camera_index.at(image.camera_id);
      if (!Project(model.cameras[camera], image.cam_from_world * point.xyz)) {
        continue;
      }
      blocks.observations.push_back(
          {it->second, camera, p, image.points2d[element.point2d_index].xy});
    }
    if (blocks.observations.size() - first < 2) {
      blocks.observations.resize(first);
    }
  }
  for (const Observation& observation : blocks.observations) {
    ++blocks.poses[observation.image].observations;
  }
  return blocks;
}

constexpr size_t kMinObservations = 3;  // Two numbers each; a pose has six.

// Holds what the observations cannot tell: the place, orientation and scale of
// the whole, and poses with too few observations.
Status FixGauge(const Reconstruction& model,
                Blocks* blocks,
                ceres::Problem* problem) {
  constexpr size_t kNone = std::numeric_limits<size_t>::max();
  size_t first = kNone;
  for (size_t i = 0; i < blocks->poses.size(); ++i) {
    PoseBlock& pose = blocks->poses[i];
    if (pose.observations == 0) continue;
    if (pose.observations < kMinObservations) {
      problem->SetParameterBlockConstant(pose.values.data());
    } else if (first == kNone) {
      first = i;
      problem->SetParameterBlockConstant(pose.values.data());
    }
  }
  size_t second = kNone;
  double farthest = 0;
  for (size_t i = 0; first != kNone && i < blocks->poses.size(); ++i) {
    if (blocks->poses[i].observations < kMinObservations) continue;
    const double distance = (CameraCentre(model.images[i].cam_from_world) -
                             CameraCentre(model.images[first].cam_from_world))
                                .norm();
    if (distance > farthest) {
      farthest = distance;
      second = i;
    }
  }
  if (second == kNone) {
    return UnusableResultError(
        "bundle adjustment needs two photos, at different places, with at "
        "least " +
        std::to_string(kMinObservations) +
        " observations of points seen twice in front of the cameras");
  }
  // Scaling about the first centre moves the second's translation along this.
  const Eigen::Vector3d along =
      model.images[second].cam_from_world.rotation *
      (CameraCentre(model.images[second].cam_from_world) -
       CameraCentre(model.images[first].cam_from_world));
  int coordinate = 0;
  along.cwiseAbs().maxCoeff(&coordinate);
  problem->SetManifold(blocks->poses[second].values.data(),
                       new ceres::SubsetManifold(6, {3 + coordinate}));
  return {};
}

// Points first: each is eliminated by its own 3 x 3 block (Schur complement).
ceres::Solver::Options SolverOptions(const BundleAdjustmentOptions& options,
                                     Blocks* blocks,
                                     const ceres::Problem& problem) {
  ceres::Solver::Options solver;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = options.function_tolerance;
  solver.gradient_tolerance = 1e-10;
  solver.parameter_tolerance = 1e-8;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  solver.max_num_consecutive_invalid_steps = 10;
  solver.linear_solver_type = blocks->poses.size() <= kMaxDenseImages
                                  ? ceres::DENSE_SCHUR
                                  : ceres::ITERATIVE_SCHUR;
  solver.preconditioner_type = ceres::SCHUR_JACOBI;
  // Not BLAS, whose threads are not ours to set.
  solver.dense_linear_algebra_library_type = ceres::EIGEN;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  const auto add = [&](double* values, int group) {
    if (problem.HasParameterBlock(values)) {
      ordering->AddElementToGroup(values, group);
    }
  };
  for (auto& point : blocks->points) add(point.data(), 0);
  for (PoseBlock& pose : blocks->poses) add(pose.values.data(), 1);
  for (LensBlock& lens : blocks->lenses) add(lens.values.data(), 2);
  solver.linear_solver_ordering = ordering;
  return solver;
}

class StopWhenCancelled : public ceres::IterationCallback {
 public:
  explicit StopWhenCancelled(const CancellationToken* token) : token_(token) {}
  ceres::CallbackReturnType operator()(
      const ceres::IterationSummary&) override {
    return IsCancelled(token_) ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const CancellationToken* token_;
};

// The model with the adjusted values; an error when they are not usable.
Status Store(const Blocks& blocks,
             const ceres::Problem& problem,
             Reconstruction* model) {
  Reconstruction adjusted = *model;
  for (size_t i = 0; i < blocks.poses.size(); ++i) {
    const PoseBlock& block = blocks.poses[i];
    if (!problem.HasParameterBlock(block.values.data()) ||
        problem.IsParameterBlockConstant(block.values.data())) {
      continue;
    }
    const Eigen::Vector3d delta(block.values.data());
    const double angle = delta.norm();
    Rigid3d& pose = adjusted.images[i].cam_from_world;
    if (angle > 0) {
      pose.rotation =
          (Eigen::Quaterniond(Eigen::AngleAxisd(angle, delta / angle)) *
           pose.rotation)
              .normalized();
    }
    pose.translation = Eigen::Vector3d(block.values.data() + 3);
  }
  for (size_t i = 0; i < blocks.lenses.size(); ++i) {
    Camera& camera = adjusted.cameras[i];
    const auto& values = blocks.lenses[i].values;
    const int num_focal = GetCameraModel(camera.model).num_focal;
    std::copy_n(values.begin(), num_focal, camera.params.begin());
    std::copy_n(values.begin() + num_focal,
                camera.Distortion().size(),
                camera.params.begin() + num_focal + 2);
  }
  for (size_t i = 0; i < blocks.points.size(); ++i) {
    adjusted.points3d[i].xyz = Eigen::Vector3d(blocks.points[i].data());
  }
  const Status usable = CheckReconstruction(adjusted);
  if (!usable.ok()) {
    return UnusableResultError("bundle adjustment went astray: " +
                               usable.message());
  }
  *model = std::move(adjusted);
  return {};
}

}  // namespace

Status BundleAdjustmentOptions::Check() const {
  if (max_iterations < 1 || !(function_tolerance >= 0)) {
    return InvalidArgumentError(
        "bundle adjustment needs at least one iteration and a tolerance that "
        "is not negative");
  }
  return {};
}

bool CanAdjust(CameraModel model) {
  return static_cast<int>(model) >= 0 &&
         static_cast<int>(model) <=
             static_cast<int>(CameraModel::kOpenCvFisheye);
}

Status AdjustBundle(const BundleAdjustmentOptions& options,
                    Reconstruction* model) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  FREEGS_RETURN_IF_ERROR(CheckReconstruction(*model));
  for (const Camera& camera : model->cameras) {
    if (!CanAdjust(camera.model)) {
      return BadInputError("cameras of the model " +
                           std::string(GetCameraModel(camera.model).name) +
                           " cannot be adjusted");
    }
  }
  Blocks blocks = MakeBlocks(*model);
  if (blocks.observations.empty()) {
    return UnusableResultError(
        "bundle adjustment needs points that two photos see in front of their "
        "cameras; there are none");
  }

  ceres::CauchyLoss loss(kLossScalePx);
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  for (const Observation& observation : blocks.observations) {
    PoseBlock& pose = blocks.poses[observation.image];
    LensBlock& lens = blocks.lenses[observation.camera];
    problem.AddResidualBlock(MakeCost(model->cameras[observation.camera].model,
                                      pose,
                                      lens,
                                      observation.xy),
                             &loss,
                             pose.values.data(),
                             blocks.points[observation.point].data(),
                             lens.values.data());
  }
  FREEGS_RETURN_IF_ERROR(FixGauge(*model, &blocks, &problem));

  ceres::Solver::Options solver = SolverOptions(options, &blocks, problem);
  StopWhenCancelled callback(options.cancellation);
  solver.callbacks.push_back(&callback);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (summary.termination_type == ceres::USER_FAILURE) {
    return InterruptedError("stopped on request");
  }
  if (!summary.IsSolutionUsable()) {
    return UnusableResultError("bundle adjustment found no solution: " +
                               summary.message);
  }
  return Store(blocks, problem, model);
}

}  // namespace freegs::sfm
