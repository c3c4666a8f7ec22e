// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/feature_grids.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "core/io/files.h"
#include "semantics/geometry/directions.h"

namespace freegs::semantics {
namespace {

constexpr size_t kSampledCells = 16384;

std::string HashPixels(const ImageU8& image) {
  return HashBytes(std::string_view(reinterpret_cast<const char*>(image.data()),
                                    image.size())) +
         " " + std::to_string(image.width());
}

// Collects an even sample of the cells of all views.
class CellSample {
 public:
  explicit CellSample(size_t num_views) : num_views_(num_views) {}

  void Add(const ImageF& features) {
    const size_t cells = features.num_pixels();
    const size_t stride = std::max<size_t>(
        1, (cells * num_views_ + kSampledCells - 1) / kSampledCells);
    // The samples of views are shifted against each other. Otherwise a stride
    // that divides the width of the grid would always meet the same columns.
    for (size_t i = seen_++ % stride; i < cells; i += stride) {
      const float* cell = features.data() + i * features.channels();
      rows_.insert(rows_.end(), cell, cell + features.channels());
    }
  }

  const std::vector<float>& rows() const { return rows_; }

 private:
  const size_t num_views_;
  size_t seen_ = 0;
  std::vector<float> rows_;
};

}  // namespace

Status FeatureGridOptions::Check() const {
  if (dense_size < 0 || dim < 0 || max_dim < 1 || dim > 65536 ||
      max_dim > 65536) {
    return InvalidArgumentError(
        "dense_size and dim must not be negative and max_dim must be positive "
        "(up to 65536)");
  }
  if (!(kept_energy > 0 && kept_energy <= 1)) {
    return InvalidArgumentError("kept_energy must lie in (0, 1]");
  }
  return Status();
}

StatusOr<FeatureGrids> ComputeFeatureGrids(
    size_t num_views,
    ViewPhoto photo_of,
    ClipEncoder& encoder,
    const FeatureCache& cache,
    const FeatureGridOptions& options,
    ThreadPool& pool,
    const CancellationToken* cancellation,
    ViewsDone done) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  if (num_views == 0) {
    return InvalidArgumentError("there are no views to compute features of");
  }
  FeatureGrids result;
  CellSample sample(num_views);
  for (size_t view = 0; view < num_views; ++view) {
    if (cancellation != nullptr && cancellation->cancelled()) {
      return InterruptedError("computing features of views was interrupted");
    }
    FREEGS_ASSIGN_OR_RETURN(const ImageU8 photo, photo_of(view));
    FREEGS_ASSIGN_OR_RETURN(
        ImageF features,
        EncodeDenseCached(
            encoder, cache, HashPixels(photo), photo, options.dense_size));
    MakeUnitRows(features.channels(),
                 std::span(features.data(), features.size()));
    sample.Add(features);
    result.grids.push_back(std::move(features));
    done(view + 1);
  }
  const int channels = result.grids.front().channels();
  FREEGS_ASSIGN_OR_RETURN(
      result.axes, ComputePrincipalAxes(sample.rows(), channels, false, pool));
  result.axes.Keep(
      options.dim > 0
          ? std::min(options.dim, channels)
          : AxesForEnergy(
                result.axes.energies, 1, options.kept_energy, options.max_dim));
  for (ImageF& grid : result.grids) {
    const std::vector<float> reduced =
        ProjectOntoAxes(result.axes, std::span(grid.data(), grid.size()), pool);
    ImageF small(grid.width(), grid.height(), result.axes.count);
    std::copy(reduced.begin(), reduced.end(), small.data());
    grid = std::move(small);
  }
  return result;
}

}  // namespace freegs::semantics
