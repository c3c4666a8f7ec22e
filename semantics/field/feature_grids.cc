// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/feature_grids.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "core/io/files.h"
#include "semantics/geometry/directions.h"
#include "semantics/geometry/view_loop.h"

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

ImageF ProjectCells(const PrincipalAxes& axes,
                    const ImageF& cells,
                    ThreadPool& pool) {
  const std::vector<float> reduced =
      ProjectOntoAxes(axes, std::span(cells.data(), cells.size()), pool);
  ImageF small(cells.width(), cells.height(), axes.count);
  std::copy(reduced.begin(), reduced.end(), small.data());
  return small;
}

// The cells on both sides of a pixel's centre, and how near the second one is.
struct BilinearTap {
  int first = 0;
  int second = 0;
  float share = 0;
};

BilinearTap TapOf(int pixel, int pixels, int cells) {
  const double place =
      std::clamp((pixel + 0.5) * cells / pixels - 0.5, 0.0, cells - 1.0);
  const auto first = static_cast<int>(place);
  return {
      first, std::min(first + 1, cells - 1), static_cast<float>(place - first)};
}

void SampleCells(const ImageF& grid,
                 const BilinearTap& x,
                 const BilinearTap& y,
                 float* out) {
  const auto cell = [&grid](int column, int row) {
    const size_t index = static_cast<size_t>(row) * grid.width() + column;
    return grid.data() + index * grid.channels();
  };
  const float* corners[] = {cell(x.first, y.first),
                            cell(x.second, y.first),
                            cell(x.first, y.second),
                            cell(x.second, y.second)};
  const float weights[] = {(1 - x.share) * (1 - y.share),
                           x.share * (1 - y.share),
                           (1 - x.share) * y.share,
                           x.share * y.share};
  for (int c = 0; c < grid.channels(); ++c) {
    out[c] = 0;
    for (int k = 0; k < 4; ++k) out[c] += weights[k] * corners[k][c];
  }
}

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
  result.upsampled = encoder.upsampled_size() > 0 &&
                     (options.dense_size == 0 ||
                      options.dense_size == encoder.dense_sizes().front());
  result.grids.resize(num_views);
  FREEGS_RETURN_IF_ERROR(ForEachView(
      "computing features of views",
      num_views,
      pool,
      cancellation,
      done,
      [&](size_t view) -> Status {
        FREEGS_ASSIGN_OR_RETURN(const ImageU8 photo, photo_of(view));
        FREEGS_ASSIGN_OR_RETURN(
            result.grids[view],
            EncodeDenseCached(
                encoder, cache, HashPixels(photo), photo, options.dense_size));
        return Status();
      }));
  CellSample sample(num_views);
  for (ImageF& grid : result.grids) {
    // The upsampler takes features as the network gives them.
    ImageF features = grid;
    MakeUnitRows(features.channels(),
                 std::span(features.data(), features.size()));
    sample.Add(features);
    if (!result.upsampled) grid = std::move(features);
  }
  const int channels = result.grids.front().channels();
  FREEGS_ASSIGN_OR_RETURN(
      result.axes, ComputePrincipalAxes(sample.rows(), channels, false, pool));
  result.axes.Keep(
      options.dim > 0
          ? std::min(options.dim, channels)
          : AxesForEnergy(
                result.axes.energies, 1, options.kept_energy, options.max_dim));
  for (size_t view = 0; view < num_views; ++view) {
    ImageF& grid = result.grids[view];
    if (result.upsampled) {
      if (IsCancelled(cancellation)) {
        return InterruptedError("upsampling features was interrupted");
      }
      FREEGS_ASSIGN_OR_RETURN(const ImageU8 photo, photo_of(view));
      FREEGS_ASSIGN_OR_RETURN(grid, encoder.Upsample(grid, photo));
      MakeUnitRows(grid.channels(), std::span(grid.data(), grid.size()));
    }
    grid = ProjectCells(result.axes, grid, pool);
  }
  return result;
}

StatusOr<ImageF> UpsampleView(const FeatureGrids& grids,
                              size_t view,
                              const ImageF& guide,
                              const JointBilateralOptions& options,
                              ThreadPool& pool) {
  const ImageF& grid = grids.grids[view];
  if (!grids.upsampled) {
    return JointBilateralUpsample(grid, guide, options, pool);
  }
  ImageF result(guide.width(), guide.height(), grid.channels());
  pool.ParallelFor(0, guide.height(), 8, [&](int64_t first, int64_t last, int) {
    float* out = result.data() +
                 static_cast<size_t>(first) * guide.width() * grid.channels();
    for (auto y = static_cast<int>(first); y < last; ++y) {
      const BilinearTap rows = TapOf(y, guide.height(), grid.height());
      for (int x = 0; x < guide.width(); ++x, out += grid.channels()) {
        SampleCells(grid, TapOf(x, guide.width(), grid.width()), rows, out);
      }
    }
  });
  return result;
}

StatusOr<std::vector<float>> UpsampleViewAt(
    const FeatureGrids& grids,
    size_t view,
    const ImageF& guide,
    std::span<const PixelIndex> pixels,
    const JointBilateralOptions& options,
    ThreadPool& pool) {
  const ImageF& grid = grids.grids[view];
  if (!grids.upsampled) {
    return JointBilateralUpsampleAt(grid, guide, pixels, options, pool);
  }
  std::vector<float> result(pixels.size() * grid.channels());
  float* out = result.data();
  for (const PixelIndex& pixel : pixels) {
    SampleCells(grid,
                TapOf(pixel.x, guide.width(), grid.width()),
                TapOf(pixel.y, guide.height(), grid.height()),
                out);
    out += grid.channels();
  }
  return result;
}

}  // namespace freegs::semantics
