// SPDX-License-Identifier: BSD-3-Clause
// Looks at patches in the photographs and in space, and makes a RegionGraph of
// them.
//
//   PatchGraphBuilder builder(
//       model, patch_of_gaussian, normals, size_of_patch, depth_scale);
//   builder.AddView(cues);
//   const RegionGraph graph = builder.Finish(seen);

#ifndef FREEGS_SEMANTICS_PATCHES_PATCH_GRAPH_H_
#define FREEGS_SEMANTICS_PATCHES_PATCH_GRAPH_H_

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "semantics/patches/region_graph.h"
#include "semantics/patches/view_cues.h"
#include "splat/scene/gaussian_model.h"
#include "splat/weights/blending_weights.h"

namespace freegs::semantics {

// The patch that each pixel of a view shows most of, -1 where all patches
// together have less than half of its weight.
Image<int32_t> PatchOfPixels(const splat::WeightMatrix& weights,
                             std::span<const int32_t> patch_of_gaussian);

class PatchGraphBuilder {
 public:
  // patch_of_gaussian: for each Gaussian of the model, -1 for none.
  // normals: of each Gaussian, N x 3, of any sign. size_of_patch: the usual
  // extent of each patch. depth_scale: depths that differ by less than this
  // say nothing. These lengths are in units of the model frame
  // (splat/scene/model_frame.h). The model must outlive the builder.
  PatchGraphBuilder(const splat::GaussianModel& model,
                    std::vector<int32_t> patch_of_gaussian,
                    std::span<const float> normals,
                    std::vector<float> size_of_patch,
                    std::vector<float> depth_scale);

  const std::vector<int32_t>& patch_of_gaussian() const {
    return patch_of_gaussian_;
  }

  // The cues are of this model.
  void AddView(const ViewCues& cues);

  // To be called once, after all views. seen: for each Gaussian, how many
  // pixels of all views it covers. No region has semantics.
  RegionGraph Finish(std::span<const double> seen);

 private:
  // Planes of the patches in the camera frame of a view.
  class PatchDepths;
  struct Boundaries;

  struct Crossing {
    int32_t a = 0;
    int32_t b = 0;
    ContactStats stats;
  };

  // The patch that each pixel shows most of, -1 for none.
  void AddPixels(const Image<int32_t>& labels, const ImageF& lab);
  void AddCrossings(const std::vector<Crossing>& crossings);
  ContactStats& ContactOf(int32_t a, int32_t b);
  void AddContext();
  void AddCreases();
  void AddGaussians(std::span<const double> seen);

  const splat::GaussianModel& model_;
  std::vector<int32_t> patch_of_gaussian_;
  std::vector<float> size_of_patch_;
  std::vector<float> depth_scale_;
  std::vector<Eigen::Vector3d> towards_camera_;  // One for each patch.
  std::vector<Eigen::Vector3d> middle_;          // Mean position of each patch.
  std::vector<Eigen::Vector3d> normal_;          // Mean normal, of any sign.
  std::unordered_map<uint64_t, size_t> contact_index_;
  RegionGraph graph_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_PATCH_GRAPH_H_
