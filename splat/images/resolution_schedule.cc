// SPDX-License-Identifier: BSD-3-Clause

#include "splat/images/resolution_schedule.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <opencv2/core.hpp>

#include "splat/images/ignored_pixels.h"

namespace freegs::splat {
namespace {

// How many photos are looked at, spread evenly over all, and the shortest side
// that a level may have.
constexpr size_t kMaxPhotos = 8;
constexpr int kMinSide = 32;

// The share of the iterations that a level would get if it showed the whole
// spectrum.
constexpr double kCoarsePart = 0.25;

// Sums of amplitudes below this share of the sum of an image of one colour are
// rounding errors.
constexpr double kNoise = 1e-5;

// The mean over the channels of the pixels that a mask uses; 0 of none.
float MeanOfUsed(const ImageU8& mask, const ImageF& photo) {
  const auto channels = static_cast<size_t>(photo.channels());
  double sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < photo.size(); ++i) {
    if (mask.data()[i / channels] == 0) continue;
    sum += photo.data()[i];
    ++count;
  }
  return count > 0 ? static_cast<float>(sum / static_cast<double>(count)) : 0;
}

double Hann(int i, int count) {
  return 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (i + 0.5) / count);
}

// Cycles per pixel of row or column i of a discrete Fourier transform.
double Frequency(int i, int count) {
  return static_cast<double>(std::min(i, count - i)) / count;
}

// Grey values minus their mean, faded out towards the borders. Rows and columns
// of zeros follow, because sides with large prime factors would take minutes to
// transform.
cv::Mat WindowedGrey(const ImageF& image) {
  cv::Mat padded(cv::getOptimalDFTSize(image.height()),
                 cv::getOptimalDFTSize(image.width()),
                 CV_32F,
                 cv::Scalar(0));
  cv::Mat grey = padded(cv::Rect(0, 0, image.width(), image.height()));
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      grey.at<float>(y, x) = image(x, y, 0) + image(x, y, 1) + image(x, y, 2);
    }
  }
  grey -= cv::mean(grey)[0];
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      grey.at<float>(y, x) *=
          static_cast<float>(Hann(y, image.height()) * Hann(x, image.width()));
    }
  }
  return padded;
}

}  // namespace

std::vector<double> SpectrumShares(const ImageF& image, int num_levels) {
  cv::Mat spectrum;
  cv::dft(WindowedGrey(image), spectrum, cv::DFT_COMPLEX_OUTPUT);
  std::vector<double> sums(num_levels, 0.0);
  for (int y = 0; y < spectrum.rows; ++y) {
    for (int x = 0; x < spectrum.cols; ++x) {
      if (x == 0 && y == 0) continue;
      const auto value = spectrum.at<cv::Vec2f>(y, x);
      const double amplitude = std::hypot(value[0], value[1]);
      const double frequency =
          std::max(Frequency(y, spectrum.rows), Frequency(x, spectrum.cols));
      for (int k = 0; k < num_levels && frequency <= 0.5 / (1 << k); ++k) {
        sums[k] += amplitude;
      }
    }
  }
  // An image of one colour has no spectrum, and every level shows all of it.
  const double total = sums[0];
  const double noise = kNoise * static_cast<double>(spectrum.total());
  for (double& sum : sums) sum = total > noise ? sum / total : 1.0;
  return sums;
}

StatusOr<std::vector<double>> SpectrumResolutionSteps(TrainingImages* images) {
  int num_levels = images->num_levels();
  const size_t count = std::min(kMaxPhotos, images->size());
  std::vector<double> means(num_levels, 0.0);
  ImageF photo;
  for (size_t i = 0; i < count; ++i) {
    const size_t index = i * images->size() / count;
    FREEGS_RETURN_IF_ERROR(images->Fetch(index, 0, &photo));
    if (const ImageU8* const mask = images->Mask(index, 0)) {
      FillIgnored(*mask, MeanOfUsed(*mask, photo), &photo);
    }
    while (num_levels > 1 && (std::min(photo.width(), photo.height()) >>
                              (num_levels - 1)) < kMinSide) {
      --num_levels;
    }
    const std::vector<double> shares = SpectrumShares(photo, num_levels);
    for (int k = 0; k < num_levels; ++k) {
      means[k] += shares[k] / static_cast<double>(count);
    }
  }
  std::vector<double> steps;
  for (int k = num_levels - 1; k > 0; --k) {
    steps.push_back(kCoarsePart * means[k]);
  }
  return steps;
}

}  // namespace freegs::splat
