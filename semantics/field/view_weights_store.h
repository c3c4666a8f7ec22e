// SPDX-License-Identifier: BSD-3-Clause
// Keeps the blending weights of all views of a scene, within limits on memory
// and disk space. Since the geometry is frozen in the second phase of FreeGS,
// the weights are constants, which every step that blends features reads again.
//
//   FREEGS_ASSIGN_OR_RETURN(
//       ViewWeightsStore store,
//       ViewWeightsStore::Create(model, views, render, ViewWeightsOptions()));
//   FREEGS_ASSIGN_OR_RETURN(const ViewWeights weights,
//                           store.Weights(view, pool));
//   // weights.matrix() blends features of Gaussians onto the view's pixels.

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
  // The longest side, in pixels, of the images onto which features are blended.
  // Smaller views keep their size, and with 0 all do. FreeGS distils features
  // of 224 x 224.
  int max_side = 224;

  // The memory that the store may use for weights. Callers hold more: usually
  // the one view that they work on.
  uint64_t max_memory_bytes = uint64_t{1} << 30;

  // Weights that do not fit in memory are written to this folder, up to
  // max_scratch_bytes, and only while its disk keeps min_free_disk_bytes for
  // checkpoints and results. Without a folder, and beyond these limits, weights
  // are computed again each time.
  std::filesystem::path scratch_folder;
  uint64_t max_scratch_bytes = uint64_t{1} << 34;
  uint64_t min_free_disk_bytes = uint64_t{1} << 30;

  Status Check() const;
};

// The weights of one view. Copies are cheap and share the arrays, which live as
// long as any copy, even if the store is gone.
class ViewWeights {
 public:
  ViewWeights(const splat::WeightMatrix& matrix,
              std::shared_ptr<const void> owner)
      : matrix_(matrix), owner_(std::move(owner)) {}

  const splat::WeightMatrix& matrix() const { return matrix_; }

 private:
  splat::WeightMatrix matrix_;
  std::shared_ptr<const void> owner_;  // Owns the matrix's arrays.
};

// Computes the weights of a view when they are first asked for. Where weights
// are kept changes how long the next call takes, but never their bytes. The
// views asked for first stay in memory: if all views are used in turn, as in
// training, a store that dropped the oldest would never have the view that is
// needed next.
class ViewWeightsStore {
 public:
  // Keeps a pointer to the model, which must outlive the store and must not
  // change. kInvalidArgument for options out of range; kInternal if the scratch
  // folder does not exist or cannot be written.
  static StatusOr<ViewWeightsStore> Create(const splat::GaussianModel& model,
                                           std::span<const View> views,
                                           const splat::RenderOptions& render,
                                           const ViewWeightsOptions& options);

  size_t num_views() const { return views_.size(); }
  size_t num_gaussians() const { return model_->size(); }

  // The camera of a view, at the size of its weights.
  const Pinhole& camera(size_t view) const { return views_[view].camera; }
  const std::string& name(size_t view) const { return views_[view].name; }

  // Only one thread may call this at a time. kInvalidArgument for a view that
  // does not exist; errors of ComputeBlendingWeights, with the name of the
  // view. If a scratch file cannot be written, the store goes on without the
  // disk.
  StatusOr<ViewWeights> Weights(size_t view, ThreadPool& pool);

 private:
  ViewWeightsStore(const splat::GaussianModel& model,
                   std::span<const View> views,
                   const splat::RenderOptions& render,
                   const ViewWeightsOptions& options);

  // Stores weights that were just computed, if there is room, and returns them
  // from where they are now.
  ViewWeights Keep(size_t view, splat::BlendingWeights weights);

  // If the limits on disk space allow so many bytes more.
  bool HasDiskFor(uint64_t bytes) const;

  const splat::GaussianModel* model_;
  std::vector<View> views_;  // Cameras at the size of the weights.
  splat::RenderOptions render_;
  ViewWeightsOptions options_;
  std::vector<std::optional<ViewWeights>> kept_;
  uint64_t memory_bytes_ = 0;  // Kept in memory.
  uint64_t disk_bytes_ = 0;    // Kept in scratch files.
  bool disk_failed_ = false;   // A scratch file could not be written.
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_VIEW_WEIGHTS_STORE_H_
