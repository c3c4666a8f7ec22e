// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/true_masks.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/io/image_io.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxMasks = 256;

// Reads a file of one object: 1 where the object is, else 0.
StatusOr<ImageU16> ReadBright(const fs::path& path) {
  constexpr int kThreshold = 128;
  FREEGS_ASSIGN_OR_RETURN(const ImageU8 image, ReadRgb(path));
  ImageU16 mask(image.width(), image.height(), 1);
  int brightest = 0;
  for (size_t i = 0; i < mask.num_pixels(); ++i) {
    const uint8_t* rgb = image.data() + 3 * i;
    // Luma of ITU-R BT.601.
    const int value = (299 * rgb[0] + 587 * rgb[1] + 114 * rgb[2]) / 1000;
    mask.data()[i] = static_cast<uint16_t>(value);
    brightest = std::max(brightest, value);
  }
  const int threshold = brightest <= 1 ? 0 : kThreshold;
  for (size_t i = 0; i < mask.size(); ++i) {
    mask.data()[i] = mask.data()[i] > threshold ? 1 : 0;
  }
  return mask;
}

// Resamples mask files, whose lens may distort, to the pixels of `camera`.
// Where the lens shows each of them is worked out once for all files of a view.
class MaskSampler {
 public:
  // lens: null if the files are of `camera` itself.
  MaskSampler(const Pinhole& camera, const sfm::Camera* lens, ThreadPool& pool)
      : camera_(camera), lens_(lens) {
    if (lens == nullptr) return;
    in_lens_.resize(static_cast<size_t>(camera.width) * camera.height);
    pool.ParallelFor(
        0, camera.height, 16, [&](int64_t first, int64_t last, int) {
          for (int y = static_cast<int>(first); y < last; ++y) {
            for (int x = 0; x < camera.width; ++x) {
              const std::optional<Eigen::Vector2d> pixel =
                  sfm::Project(*lens,
                               {(x + 0.5 - camera.cx) / camera.fx,
                                (y + 0.5 - camera.cy) / camera.fy,
                                1});
              in_lens_[static_cast<size_t>(y) * camera.width + x] =
                  pixel.value_or(Eigen::Vector2d(-1, -1));
            }
          }
        });
  }

  StatusOr<ImageU16> Sample(const ImageU16& file,
                            const std::string& name) const {
    const double width =
        lens_ != nullptr ? static_cast<double>(lens_->width) : camera_.width;
    const double height =
        lens_ != nullptr ? static_cast<double>(lens_->height) : camera_.height;
    if (!SameShape(file.width(), file.height(), width, height)) {
      return BadInputError(name + ": is of " + std::to_string(file.width()) +
                           " x " + std::to_string(file.height()) +
                           " pixels, its view of " +
                           std::to_string(std::lround(width)) + " x " +
                           std::to_string(std::lround(height)));
    }
    ImageU16 result(camera_.width, camera_.height, 1);
    const double x_scale = file.width() / width;
    const double y_scale = file.height() / height;
    for (int y = 0; y < camera_.height; ++y) {
      for (int x = 0; x < camera_.width; ++x) {
        const Eigen::Vector2d pixel = InLens(x, y);
        const double u = std::floor(pixel.x() * x_scale);
        const double v = std::floor(pixel.y() * y_scale);
        if (u < 0 || v < 0 || u >= file.width() || v >= file.height()) continue;
        result(x, y) = file(static_cast<int>(u), static_cast<int>(v));
      }
    }
    return result;
  }

 private:
  // Where the middle of a pixel is in the files, at the size of the lens;
  // negative where the lens does not show it.
  Eigen::Vector2d InLens(int x, int y) const {
    if (lens_ == nullptr) return {x + 0.5, y + 0.5};
    return in_lens_[static_cast<size_t>(y) * camera_.width + x];
  }

  Pinhole camera_;
  const sfm::Camera* lens_;
  std::vector<Eigen::Vector2d> in_lens_;
};

// Adds the object to the first layer in which it covers no other object.
void AddObject(const ImageU16& mask, int object, MaskLayers* layers) {
  const auto is_free = [&mask](const ImageU16& layer) {
    for (size_t i = 0; i < mask.size(); ++i) {
      if (mask.data()[i] != 0 && layer.data()[i] != 0) return false;
    }
    return true;
  };
  auto layer = std::find_if(layers->begin(), layers->end(), is_free);
  if (layer == layers->end()) {
    layers->emplace_back(mask.width(), mask.height(), 1);
    layer = std::prev(layers->end());
  }
  for (size_t i = 0; i < mask.size(); ++i) {
    if (mask.data()[i] != 0) layer->data()[i] = static_cast<uint16_t>(object);
  }
}

}  // namespace

StatusOr<MaskLayers> ReadTrueMasks(const GroundTruth& truth,
                                   const View& view,
                                   ThreadPool& pool) {
  const std::vector<MaskFile>& files = truth.masks.at(view.name);
  if (files.size() > kMaxMasks) {
    return BadInputError(view.name + ": has " + std::to_string(files.size()) +
                         " masks; more than " + std::to_string(kMaxMasks) +
                         " are refused");
  }
  const auto lens = truth.lenses.find(view.name);
  const MaskSampler sampler(
      view.camera, lens == truth.lenses.end() ? nullptr : &lens->second, pool);
  MaskLayers layers;
  for (const MaskFile& file : files) {
    FREEGS_ASSIGN_OR_RETURN(
        const ImageU16 stored,
        file.object > 0 ? ReadBright(file.path) : ReadLabels(file.path));
    FREEGS_ASSIGN_OR_RETURN(ImageU16 mask,
                            sampler.Sample(stored, file.path.string()));
    if (file.object > 0) {
      AddObject(mask, file.object, &layers);
    } else {
      layers.push_back(std::move(mask));
    }
  }
  return layers;
}

ImageU8 MaskOf(const MaskLayers& layers, const std::set<int>& objects) {
  ImageU8 mask(layers[0].width(), layers[0].height(), 1);
  for (const ImageU16& layer : layers) {
    for (size_t i = 0; i < layer.size(); ++i) {
      const int object = layer.data()[i];
      if (object > 0 && objects.contains(object)) mask.data()[i] = 255;
    }
  }
  return mask;
}

}  // namespace freegs::stages
