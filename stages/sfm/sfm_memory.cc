// SPDX-License-Identifier: BSD-3-Clause

#include "stages/sfm/sfm_memory.h"

#include <algorithm>
#include <cmath>

#include "pipeline/stage.h"

namespace freegs::stages {
namespace {

// COLMAP's program and libraries.
constexpr double kColmapMemory = 20e6;

// COLMAP's extractor doubles the sides of a picture and holds on each thread
// about 20 floats for each pixel of that: scales, their differences, gradients.
constexpr double kExtractorBytesPerPixel = 330;

// Without sfm.max_image_size the side is chosen from 800 to 1600 by the number
// of features found. With this one the error is small at both ends.
constexpr int kUsualSide = 1000;

// Descriptors (128 bytes each) and the matches that a feature has in other
// photos, in the database, the mapper's graph and our own copy.
constexpr double kBytesPerFeature = 1000;

// The photo and the one without distortion, each decoded and as it is written.
constexpr double kUndistortionBytesPerPixel = 12;

double Pixels(const photos::Photo& photo, int max_side) {
  const int side = std::max({photo.width, photo.height, 1});
  const double scale =
      max_side > 0 ? std::min(1.0, static_cast<double>(max_side) / side) : 1.0;
  return scale * photo.width * scale * photo.height;
}

double LargestPixels(const photos::PhotoList& list, int max_side) {
  double largest = 0;
  for (const photos::Photo& photo : list.photos) {
    if (photo.usable()) largest = std::max(largest, Pixels(photo, max_side));
  }
  return largest;
}

}  // namespace

int64_t SfmMemory(const sfm::SfmOptions& options,
                  const photos::PhotoList& list,
                  int threads) {
  const int side =
      options.max_image_size > 0 ? options.max_image_size : kUsualSide;
  const double extraction = kColmapMemory + kExtractorBytesPerPixel * threads *
                                                LargestPixels(list, side);
  const auto usable = static_cast<double>(std::count_if(
      list.photos.begin(), list.photos.end(), [](const photos::Photo& photo) {
        return photo.usable();
      }));
  const double mapping = static_cast<double>(pipeline::kProgramMemory) +
                         kBytesPerFeature * options.max_features * usable;
  return std::llround(std::max(extraction, mapping));
}

int64_t UndistortMemory(const photos::PhotoList& list, int cores) {
  return pipeline::kProgramMemory +
         std::llround(kUndistortionBytesPerPixel * cores *
                      LargestPixels(list, 0));
}

}  // namespace freegs::stages
