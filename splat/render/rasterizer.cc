// SPDX-License-Identifier: BSD-3-Clause

#include "splat/render/rasterizer.h"

#include <algorithm>
#include <cstring>
#include <new>

#include <hwy/aligned_allocator.h>

#include "splat/render/tile_images.h"
#include "splat/render/tile_kernels.h"
#include "splat/render/tile_task.h"

namespace freegs::splat {
namespace {

using AlignedFloats = hwy::AlignedFreeUniquePtr<float[]>;

AlignedFloats TileChannels(int channels) {
  AlignedFloats floats = hwy::AllocateAligned<float>(
      static_cast<size_t>(std::max(1, channels)) * kTilePixels);
  if (floats == nullptr) throw std::bad_alloc();
  return floats;
}

// The rasterizer's functions return no Status. A view with too many pairs to be
// counted is told as one that takes too much memory, as nearly all of them do.
void BinOrThrow(const Projection& projection,
                const Pinhole& camera,
                ThreadPool& pool,
                TileBins* bins) {
  if (!BinSplats(projection, camera.width, camera.height, pool, bins).ok()) {
    throw std::bad_alloc();
  }
}

// Copies the pixels of a tile from planar tile memory into an interleaved
// image, or back.
void StoreTile(const TileTask& task,
               int channel,
               const float* plane,
               ImageF* image) {
  const int channels = image->channels();
  for (int y = 0; y < task.height; ++y) {
    float* row = image->row(task.y0 + y) + task.x0 * channels + channel;
    for (int x = 0; x < task.width; ++x) {
      row[x * channels] = plane[TilePixel(x, y)];
    }
  }
}

void LoadTile(const TileTask& task,
              int channel,
              const ImageF* image,
              float* plane) {
  std::fill_n(plane, kTilePixels, 0.0f);
  if (image == nullptr) return;
  const int channels = image->channels();
  for (int y = 0; y < task.height; ++y) {
    const float* row = image->row(task.y0 + y) + task.x0 * channels + channel;
    for (int x = 0; x < task.width; ++x) {
      plane[TilePixel(x, y)] = row[x * channels];
    }
  }
}

}  // namespace

TileTask Rasterizer::MakeTask(int64_t tile) const {
  TileTask task =
      MakeTileTask(projection_, bins_, camera_.width, camera_.height, tile);
  task.extras = extras_.data();
  task.num_extras = num_extras_;
  return task;
}

void Rasterizer::Forward(const GaussianModel& model,
                         const Pinhole& camera,
                         const Rigid3d& cam_from_world,
                         const RenderOptions& options,
                         const RasterRequest& request,
                         ThreadPool& pool,
                         RasterImages* images) {
  camera_ = camera;
  cam_from_world_ = cam_from_world;
  options_ = options;
  with_depth_ = request.depth;
  num_features_ = request.features.channels;
  num_extras_ = num_features_ + (with_depth_ ? 1 : 0);
  projector_.Project(
      model, camera, cam_from_world, options, pool, &projection_);
  BinOrThrow(projection_, camera, pool, &bins_);

  extras_.resize(model.size() * num_extras_);
  for (size_t k = 0; num_extras_ > 0 && k < projection_.size(); ++k) {
    const size_t i = projection_.visible[k];
    float* extras = &extras_[i * num_extras_];
    if (with_depth_) *extras++ = projection_.splats[i].depth;
    std::copy_n(request.features.values.data() + i * num_features_,
                num_features_,
                extras);
  }

  images->color.Reshape(camera.width, camera.height, 3);
  images->transmittance.Reshape(camera.width, camera.height, 1);
  images->extras.Reshape(camera.width, camera.height, num_extras_);
  if (request.dominant) {
    images->dominant.Reshape(camera.width, camera.height, 1);
  }
  const int64_t tiles = static_cast<int64_t>(bins_.tiles_x) * bins_.tiles_y;
  tile_visited_.resize(tiles);
  touched_.resize(bins_.num_pairs());
  pool.ParallelFor(0, tiles, 4, [&](int64_t begin, int64_t end, int) {
    TilePixels pixels;
    TileDominance dominance;
    const AlignedFloats extras =
        num_extras_ > 0 ? TileChannels(num_extras_) : AlignedFloats();
    for (int64_t tile = begin; tile < end; ++tile) {
      const TileTask task = MakeTask(tile);
      tile_visited_[tile] = BlendTile(task,
                                      &pixels,
                                      extras.get(),
                                      request.dominant ? &dominance : nullptr,
                                      touched_.data() + bins_.tile_begin[tile]);
      if (request.dominant) StoreDominant(task, dominance, &images->dominant);
      StoreColorTile(task, pixels, options.background.data(), &images->color);
      StoreTile(task, 0, pixels.transmittance, &images->transmittance);
      for (int e = 0; e < num_extras_; ++e) {
        StoreTile(task, e, extras.get() + e * kTilePixels, &images->extras);
      }
    }
  });
}

void Rasterizer::Backward(const GaussianModel& model,
                          const RasterGradients& image_gradients,
                          const RasterImages& images,
                          ThreadPool& pool,
                          GaussianGradients* gradients,
                          std::span<float> feature_gradients) {
  projection_backward_.ToModel(
      BackwardPixels(model, image_gradients, images, pool),
      pool,
      gradients,
      feature_gradients);
}

void Rasterizer::BackwardInChunks(const GaussianModel& model,
                                  const RasterGradients& image_gradients,
                                  const RasterImages& images,
                                  ThreadPool& pool,
                                  GradientSink sink) {
  projection_backward_.InChunks(
      BackwardPixels(model, image_gradients, images, pool), pool, sink);
}

SplatDerivatives Rasterizer::BackwardPixels(
    const GaussianModel& model,
    const RasterGradients& image_gradients,
    const RasterImages& images,
    ThreadPool& pool) {
  const int stride = kMomentStride + num_extras_;
  pair_moments_.resize(bins_.num_pairs() * stride);
  const int64_t tiles = static_cast<int64_t>(bins_.tiles_x) * bins_.tiles_y;
  pool.ParallelFor(0, tiles, 4, [&](int64_t begin, int64_t end, int) {
    TileGradients tile_gradients;
    alignas(64) float color[3][kTilePixels];
    alignas(64) float value[kTilePixels];
    alignas(64) float gradient[kTilePixels];
    const AlignedFloats extra_gradients =
        num_extras_ > 0 ? TileChannels(num_extras_) : AlignedFloats();
    for (int64_t tile = begin; tile < end; ++tile) {
      const TileTask task = MakeTask(tile);
      LoadColorTile(task, image_gradients.color, tile_gradients.color);
      LoadColorTile(task, &images.color, color);
      float* remaining = tile_gradients.remaining;
      for (int k = 0; k < kTilePixels; ++k) {
        remaining[k] = tile_gradients.color[0][k] * color[0][k] +
                       tile_gradients.color[1][k] * color[1][k] +
                       tile_gradients.color[2][k] * color[2][k];
      }
      const auto accumulate = [&](const float* d_value) {
        for (int k = 0; k < kTilePixels; ++k) {
          remaining[k] += d_value[k] * value[k];
        }
      };
      if (image_gradients.transmittance != nullptr) {
        LoadTile(task, 0, image_gradients.transmittance, gradient);
        LoadTile(task, 0, &images.transmittance, value);
        accumulate(gradient);
      }
      for (int e = 0; e < num_extras_; ++e) {
        LoadTile(task, e, image_gradients.extras, gradient);
        std::copy_n(
            gradient, kTilePixels, extra_gradients.get() + e * kTilePixels);
        LoadTile(task, e, &images.extras, value);
        accumulate(gradient);
      }
      BackwardTile(task,
                   {touched_.data() + bins_.tile_begin[tile],
                    static_cast<size_t>(tile_visited_[tile])},
                   &tile_gradients,
                   extra_gradients.get(),
                   pair_moments_.data() + bins_.tile_begin[tile] * stride);
    }
  });

  mean2d_gradients_.resize(2 * projection_.size());
  SplatDerivatives derivatives;
  derivatives.view =
      MakeProjectionTask(model, camera_, cam_from_world_, options_);
  derivatives.projection = &projection_;
  derivatives.bins = &bins_;
  derivatives.pair_moments = pair_moments_;
  derivatives.num_extras = num_extras_;
  derivatives.has_depth = with_depth_;
  derivatives.mean2d_gradients = mean2d_gradients_;
  return derivatives;
}

void Rasterizer::StoreDominant(const TileTask& task,
                               const TileDominance& dominance,
                               Image<int32_t>* image) const {
  for (int y = 0; y < task.height; ++y) {
    int32_t* row = image->row(task.y0 + y) + task.x0;
    for (int x = 0; x < task.width; ++x) {
      const int32_t entry = dominance.entry[TilePixel(x, y)];
      row[x] = entry < 0 ? -1 : static_cast<int32_t>(task.entries[entry]);
    }
  }
}

void Rasterizer::PrepareWeights(const GaussianModel& model,
                                const Pinhole& camera,
                                const Rigid3d& cam_from_world,
                                const RenderOptions& options,
                                ThreadPool& pool) {
  camera_ = camera;
  num_extras_ = 0;
  RenderOptions without_color = options;
  without_color.sh_degree = 0;
  projector_.Project(
      model, camera, cam_from_world, without_color, pool, &projection_);
  BinOrThrow(projection_, camera, pool, &bins_);
}

void Rasterizer::Contributions(const GaussianModel& model,
                               const Pinhole& camera,
                               const Rigid3d& cam_from_world,
                               const RenderOptions& options,
                               const ImageU8* mask,
                               ThreadPool& pool,
                               ViewContributions* contributions) {
  PrepareWeights(model, camera, cam_from_world, options, pool);
  pair_contributions_.resize(bins_.num_pairs());
  contributions->dominant.Reshape(camera.width, camera.height, 1);
  contributions->transmittance.Reshape(camera.width, camera.height, 1);
  const int64_t tiles = static_cast<int64_t>(bins_.tiles_x) * bins_.tiles_y;
  pool.ParallelFor(0, tiles, 4, [&](int64_t begin, int64_t end, int) {
    TileDominance dominance;
    alignas(64) float transmittance[kTilePixels];
    for (int64_t tile = begin; tile < end; ++tile) {
      TileTask task = MakeTask(tile);
      task.mask = mask;
      ContributeTile(task,
                     transmittance,
                     &dominance,
                     pair_contributions_.data() + bins_.tile_begin[tile]);
      StoreTile(task, 0, transmittance, &contributions->transmittance);
      StoreDominant(task, dominance, &contributions->dominant);
    }
  });

  const size_t splats = projection_.size();
  contributions->model_index = projection_.visible;
  contributions->weight_sum.assign(splats, 0.0f);
  contributions->num_pixels.assign(splats, 0);
  contributions->num_dominant.assign(splats, 0);
  std::vector<uint32_t> dominant_of_model(model.size(), 0);
  for (size_t k = 0; k < contributions->dominant.size(); ++k) {
    const int32_t i = contributions->dominant.data()[k];
    if (i >= 0) ++dominant_of_model[i];
  }
  for (size_t s = 0; s < splats; ++s) {
    for (const uint32_t entry : bins_.EntriesOf(s)) {
      const PairContribution& pair = pair_contributions_[entry];
      contributions->weight_sum[s] += pair.weight_sum;
      contributions->num_pixels[s] += static_cast<uint32_t>(pair.num_pixels);
    }
    contributions->num_dominant[s] = dominant_of_model[projection_.visible[s]];
  }
}

Image<int32_t> Rasterizer::Labels(const GaussianModel& model,
                                  const Pinhole& camera,
                                  const Rigid3d& cam_from_world,
                                  const RenderOptions& options,
                                  std::span<const int32_t> labels,
                                  float min_weight,
                                  ThreadPool& pool) {
  PrepareWeights(model, camera, cam_from_world, options, pool);
  Image<int32_t> result(camera.width, camera.height, 1, -1);
  const int64_t tiles = static_cast<int64_t>(bins_.tiles_x) * bins_.tiles_y;
  pool.ParallelFor(0, tiles, 4, [&](int64_t begin, int64_t end, int) {
    std::vector<int32_t> present;   // The tile's labels, ascending.
    std::vector<int32_t> channels;  // Per list entry: place in `present`.
    for (int64_t tile = begin; tile < end; ++tile) {
      const TileTask task = MakeTask(tile);
      present.clear();
      channels.resize(task.count);
      for (int64_t k = 0; k < task.count; ++k) {
        channels[k] = labels[task.entries[k]];
        if (channels[k] >= 0) present.push_back(channels[k]);
      }
      std::sort(present.begin(), present.end());
      present.erase(std::unique(present.begin(), present.end()), present.end());
      if (present.empty()) continue;
      for (int32_t& channel : channels) {
        if (channel < 0) continue;
        channel = static_cast<int32_t>(
            std::lower_bound(present.begin(), present.end(), channel) -
            present.begin());
      }
      const AlignedFloats votes =
          TileChannels(static_cast<int>(present.size()));
      std::fill_n(votes.get(), present.size() * kTilePixels, 0.0f);
      VoteTile(task, channels.data(), votes.get());
      for (int y = 0; y < task.height; ++y) {
        for (int x = 0; x < task.width; ++x) {
          const float* vote = votes.get() + TilePixel(x, y);
          float total = 0, best = 0;
          int32_t winner = -1;
          for (size_t l = 0; l < present.size(); ++l) {
            const float weight = vote[l * kTilePixels];
            total += weight;
            if (weight > best) {
              best = weight;
              winner = present[l];
            }
          }
          if (total >= min_weight) {
            result(task.x0 + x, task.y0 + y) = winner;
          }
        }
      }
    }
  });
  return result;
}

}  // namespace freegs::splat
