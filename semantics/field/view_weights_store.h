// SPDX-License-Identifier: BSD-3-Clause
// The blending weights of all views of a scene within bounds on memory and disk
// space. With the geometry frozen (FreeGS, second phase of training) they are
// constants, read again by every step that blends features.

#ifndef FREEGS_SEMANTICS_FIELD_VIEW_WEIGHTS_STORE_H_
#define FREEGS_SEMANTICS_FIELD_VIEW_WEIGHTS_STORE_H_

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"
#include "splat/weights/blending_weights.h"

namespace freegs::semantics {

struct ViewWeightsOptions {
  // Longest side, in pixels, of the images that features are blended onto;
  // smaller views stay as they are, and so do all with 0. FreeGS distils
  // features of 224 x 224.
  int max_side = 224;

  // What the store itself may keep. Beside it there is what callers hold: most
  // often the one view they work on.
  uint64_t max_memory_bytes = uint64_t{1} << 30;

  // Where weights go that memory has no room for, and how many bytes of them.
  // Without a folder, and beyond that, they are computed again on every use.
  std::filesystem::path scratch_folder;
  uint64_t max_scratch_bytes = uint64_t{1} << 34;

  Status Check() const;
};

// The weights of one view. A light handle: copies share the arrays, which live
// as long as any copy does, whatever becomes of the store.
class ViewWeights {
 public:
  ViewWeights(const splat::WeightMatrix& matrix,
              std::shared_ptr<const void> owner)
      : matrix_(matrix), owner_(std::move(owner)) {}

  const splat::WeightMatrix& matrix() const { return matrix_; }

 private:
  splat::WeightMatrix matrix_;
  std::shared_ptr<const void> owner_;  // Of the matrix's arrays.
};

// Computes the weights of a view when it is first asked for. Where they are
// kept changes how long the next call takes, never their bytes. Views asked for
// first stay in memory: when all are used in turn, as training does, throwing
// out the oldest would keep none that is needed next.
class ViewWeightsStore {
 public:
  // Keeps a reference to the model, which must outlive the store and not
  // change. kInvalidArgument for options out of range; kInternal when the
  // scratch folder does not exist or cannot be written.
  static StatusOr<ViewWeightsStore> Create(const splat::GaussianModel& model,
                                           std::span<const View> views,
                                           const splat::RenderOptions& render,
                                           const ViewWeightsOptions& options);

  size_t num_views() const { return views_.size(); }
  size_t num_gaussians() const { return model_->size(); }

  // The camera of a view at the size of its weights.
  const Pinhole& camera(size_t view) const { return views_[view].camera; }
  const std::string& name(size_t view) const { return views_[view].name; }

  // One call at a time. kInvalidArgument for a view that there is not; errors
  // of ComputeBlendingWeights, with the view's name. A scratch file that cannot
  // be written is no error: see scratch_status.
  StatusOr<ViewWeights> Weights(size_t view, ThreadPool& pool);

 private:
  ViewWeightsStore(const splat::GaussianModel& model,
                   std::span<const View> views,
                   const splat::RenderOptions& render,
                   const ViewWeightsOptions& options);

  // Makes a place in the store for what has just been computed, if there is
  // any, and returns the weights from there.
  ViewWeights Keep(size_t view, splat::BlendingWeights weights);

  const splat::GaussianModel* model_;
  std::vector<View> views_;  // Cameras at the size of the weights.
  splat::RenderOptions render_;
  ViewWeightsOptions options_;
  std::vector<std::optional<ViewWeights>> kept_;
  uint64_t memory_bytes_ = 0;  // Kept in memory.
  uint64_t disk_bytes_ = 0;    // Kept in scratch files.
  bool disk_full_ = false;     // A scratch file could not be written.
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_VIEW_WEIGHTS_STORE_H_
