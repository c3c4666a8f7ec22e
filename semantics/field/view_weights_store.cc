// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/view_weights_store.h"

#include <array>
#include <system_error>

#include "core/io/scratch_file.h"

namespace freegs::semantics {
namespace {

constexpr int kMaxStoredSide = 1 << 16;

// The arrays of `weights` in a file, in the order of WeightMatrix.
StatusOr<ViewWeights> MoveToDisk(const splat::WeightMatrix& weights,
                                 const std::filesystem::path& folder) {
  const std::array<std::span<const std::byte>, 3> parts = {
      std::as_bytes(weights.pixel_begin),
      std::as_bytes(weights.gaussians),
      std::as_bytes(weights.weights)};
  FREEGS_ASSIGN_OR_RETURN(ScratchFile file, ScratchFile::Write(folder, parts));
  // The numbers of all three have 4 bytes, so that each array is aligned.
  static_assert(sizeof(uint32_t) == sizeof(float));
  const auto* begin = reinterpret_cast<const uint32_t*>(file.data());
  const uint32_t* gaussians = begin + weights.pixel_begin.size();
  const uint32_t* values = gaussians + weights.gaussians.size();
  splat::WeightMatrix matrix = weights;
  matrix.pixel_begin = {begin, weights.pixel_begin.size()};
  matrix.gaussians = {gaussians, weights.gaussians.size()};
  matrix.weights = {reinterpret_cast<const float*>(values),
                    weights.weights.size()};
  return ViewWeights(matrix,
                     std::make_shared<const ScratchFile>(std::move(file)));
}

}  // namespace

Status ViewWeightsOptions::Check() const {
  if (max_side < 0 || max_side > kMaxStoredSide) {
    return InvalidArgumentError(
        "the longest side of the images that features are blended onto must "
        "lie in 0 .. " +
        std::to_string(kMaxStoredSide));
  }
  return Status();
}

StatusOr<ViewWeightsStore> ViewWeightsStore::Create(
    const splat::GaussianModel& model,
    std::span<const View> views,
    const splat::RenderOptions& render,
    const ViewWeightsOptions& options) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  if (!options.scratch_folder.empty()) {
    // Fail now, and not later when the memory is full.
    const StatusOr<ScratchFile> file =
        ScratchFile::Write(options.scratch_folder, {});
    if (!file.ok()) return file.status();
  }
  return ViewWeightsStore(model, views, render, options);
}

ViewWeightsStore::ViewWeightsStore(const splat::GaussianModel& model,
                                   std::span<const View> views,
                                   const splat::RenderOptions& render,
                                   const ViewWeightsOptions& options)
    : model_(&model),
      views_(views.begin(), views.end()),
      render_(render),
      options_(options),
      kept_(views.size()) {
  for (View& view : views_)
    view.camera = view.camera.LimitedTo(options.max_side);
}

StatusOr<ViewWeights> ViewWeightsStore::Weights(size_t view, ThreadPool& pool) {
  if (view >= views_.size()) {
    return InvalidArgumentError("there is no view " + std::to_string(view) +
                                "; the scene has " +
                                std::to_string(views_.size()));
  }
  if (kept_[view]) return *kept_[view];
  StatusOr<splat::BlendingWeights> weights = splat::ComputeBlendingWeights(
      *model_, views_[view].camera, views_[view].cam_from_world, render_, pool);
  if (!weights.ok()) return weights.status().Annotated(views_[view].name);
  return Keep(view, *std::move(weights));
}

bool ViewWeightsStore::HasDiskFor(uint64_t bytes) const {
  if (options_.scratch_folder.empty() || disk_failed_ ||
      bytes > options_.max_scratch_bytes - disk_bytes_) {
    return false;
  }
  std::error_code error;
  const uint64_t available =
      std::filesystem::space(options_.scratch_folder, error).available;
  // Where the system does not tell, writing shows if there is room.
  return error || (available >= bytes &&
                   available - bytes >= options_.min_free_disk_bytes);
}

ViewWeights ViewWeightsStore::Keep(size_t view,
                                   splat::BlendingWeights weights) {
  const auto owner =
      std::make_shared<const splat::BlendingWeights>(std::move(weights));
  const ViewWeights result(owner->matrix(), owner);
  const uint64_t bytes = result.matrix().num_bytes();
  if (bytes <= options_.max_memory_bytes - memory_bytes_) {
    memory_bytes_ += bytes;
    kept_[view] = result;
    return result;
  }
  if (!HasDiskFor(bytes)) return result;
  StatusOr<ViewWeights> on_disk =
      MoveToDisk(result.matrix(), options_.scratch_folder);
  if (!on_disk.ok()) {
    disk_failed_ = true;
    return result;
  }
  disk_bytes_ += bytes;
  kept_[view] = *on_disk;
  return *on_disk;
}

}  // namespace freegs::semantics
