// SPDX-License-Identifier: BSD-3-Clause

#include "stages/disturb/disturb_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/random.h"

namespace freegs::stages {
namespace {

using Kind = DisturbanceKind;

// The photograph's own memory as a matrix of OpenCV, channels in the order RGB.
cv::Mat MatOf(ImageU8* photo) {
  return {photo->height(),
          photo->width(),
          CV_8UC(photo->channels()),
          photo->data()};
}

void AddNoise(double sigma, uint64_t seed, cv::Mat pixels) {
  cv::Mat noise(pixels.size(), CV_MAKETYPE(CV_32F, pixels.channels()));
  cv::RNG random(seed);
  random.fill(noise, cv::RNG::NORMAL, 0, sigma);
  cv::add(pixels, noise, pixels, cv::noArray(), pixels.type());
}

double LinearOfSrgb(double value) {
  return value <= 0.04045 ? value / 12.92
                          : std::pow((value + 0.055) / 1.055, 2.4);
}

double SrgbOfLinear(double value) {
  return value <= 0.0031308 ? value * 12.92
                            : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
}

// Multiplies the light of each channel by 2 to the power of its stops.
void ChangeLight(const std::array<double, 3>& stops, cv::Mat pixels) {
  cv::Mat table(1, 256, CV_8UC3);
  for (int i = 0; i < 256; ++i) {
    for (int c = 0; c < 3; ++c) {
      const double light = LinearOfSrgb(i / 255.0) * std::exp2(stops[c]);
      table.at<cv::Vec3b>(0, i)[c] =
          cv::saturate_cast<uint8_t>(255 * SrgbOfLinear(light));
    }
  }
  cv::LUT(pixels, table, pixels);
}

// What is left of the picture without the details within its surfaces. It is
// the guided filter with the picture as its own guide: flat places become their
// mean, and edges that are much stronger than kDetail stay.
// Source: He, Sun and Tang, "Guided image filtering", ECCV 2010.
cv::Mat WithoutDetails(const cv::Mat& picture) {
  constexpr double kDetail = 0.15 * 255;
  const int radius =
      std::max(2,
               static_cast<int>(
                   std::lround(0.02 * std::max(picture.rows, picture.cols))));
  const cv::Size window(2 * radius + 1, 2 * radius + 1);
  const auto mean = [&window](const cv::Mat& of) {
    cv::Mat result;
    cv::blur(of, result, window, {-1, -1}, cv::BORDER_REFLECT);
    return result;
  };
  const cv::Mat average = mean(picture);
  const cv::Mat variance = mean(picture.mul(picture)) - average.mul(average);
  cv::Mat slope;
  cv::divide(variance, variance + cv::Scalar::all(kDetail * kDetail), slope);
  const cv::Mat offset = average - slope.mul(average);
  return mean(slope).mul(picture) + mean(offset);
}

void FadeTexture(double amount, cv::Mat pixels) {
  cv::Mat picture;
  pixels.convertTo(picture, CV_32F);
  const cv::Mat base = WithoutDetails(picture);
  const cv::Mat faded = base * amount + picture * (1 - amount);
  faded.convertTo(pixels, pixels.type());
}

// Draws a disc of coloured spots, the same ones in each photograph, at a place
// that is drawn for this one.
void PutMover(double size, uint64_t seed, cv::Mat pixels) {
  const int diameter =
      static_cast<int>(std::lround(size * std::min(pixels.rows, pixels.cols)));
  if (diameter < 1) return;
  constexpr int kSpots = 12;  // Across.
  constexpr uint64_t kPattern = 1;
  cv::Mat spots(kSpots, kSpots, CV_8UC3);
  cv::RNG pattern(kPattern);
  pattern.fill(spots, cv::RNG::UNIFORM, 0, 256);
  cv::Mat disc;
  cv::resize(spots, disc, {diameter, diameter}, 0, 0, cv::INTER_NEAREST);
  cv::Mat inside(diameter, diameter, CV_8U, cv::Scalar(0));
  cv::circle(inside,
             {diameter / 2, diameter / 2},
             diameter / 2,
             cv::Scalar(255),
             cv::FILLED);
  RandomStream random(seed, /*stream=*/0);
  const auto place = [&random, diameter](int side) {
    return static_cast<int>(
        random.Index(static_cast<uint64_t>(side - diameter + 1)));
  };
  const int x = place(pixels.cols);
  const int y = place(pixels.rows);
  disc.copyTo(pixels(cv::Rect(x, y, diameter, diameter)), inside);
}

}  // namespace

bool ChangesPixels(DisturbanceKind kind) {
  return kind == Kind::kNoise || kind == Kind::kBlur || kind == Kind::kJpeg ||
         kind == Kind::kExposure || kind == Kind::kWhiteBalance ||
         kind == Kind::kTexture || kind == Kind::kMover;
}

void DisturbPixels(const Disturbance& disturbance,
                   const PhotoTurn& turn,
                   ImageU8* photo) {
  const cv::Mat pixels = MatOf(photo);
  const double amount = disturbance.amount;
  const double stops = amount * (turn.along - 0.5);
  switch (disturbance.kind) {
    case Kind::kNoise:
      return AddNoise(amount, turn.seed, pixels);
    case Kind::kBlur:
      if (amount > 0) cv::GaussianBlur(pixels, pixels, {0, 0}, amount);
      return;
    case Kind::kExposure:
      return ChangeLight({stops, stops, stops}, pixels);
    case Kind::kWhiteBalance:
      return ChangeLight({stops / 2, 0, -stops / 2}, pixels);
    case Kind::kTexture:
      return FadeTexture(amount, pixels);
    case Kind::kMover:
      return PutMover(amount, turn.seed, pixels);
    default:
      return;
  }
}

}  // namespace freegs::stages
