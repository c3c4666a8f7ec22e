// SPDX-License-Identifier: BSD-3-Clause
// What exposure and white balance of a photograph do to the colours of the
// scene, as an affine function for each photograph that training learns.
// Without it the differences between photographs become fog in front of the
// cameras.

#ifndef FREEGS_SPLAT_OPTIM_EXPOSURE_H_
#define FREEGS_SPLAT_OPTIM_EXPOSURE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"

namespace freegs::splat {

struct ExposureOptions {
  // Whether each photograph has colours of its own.
  bool learn = false;

  // They are learnt from this share of the iterations on: before, the scene has
  // no colours to compare with.
  double start = 0.1;

  // The rate of Adam at the start and at the end; it decays exponentially.
  double rate_initial = 0.01;
  double rate_final = 0.001;

  // Each step takes this times the rate off the difference from the identity.
  // Colours that depend on the viewing direction can stand for exposure; so
  // that the two do not drift apart, what no photograph asks for stays small.
  double pull = 5;

  Status Check() const;
};

// A 3 x 4 matrix, row-major: photo = matrix[:, 0:3] * scene + matrix[:, 3], for
// RGB.
struct AffineColor {
  std::array<float, 12> values = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

  friend bool operator==(const AffineColor&, const AffineColor&) = default;
};

// What training learnt about a photograph.
struct PhotoExposure {
  std::string photo;
  AffineColor color;
};

// The exposure to expect of a photograph: between those of the photographs
// before and after it, by name (NaturalLess). A camera changes exposure slowly
// along its way, so this is closer than that of the whole scene. Where the
// three names differ in one number only, like those of the frames of a film,
// the number says how far it is from each; otherwise the mean of the two is
// taken. What was learnt of the photograph itself does not count. `exposures`
// are in the order of the names; without any other photograph it is the
// identity.
AffineColor ExposureBetween(std::span<const PhotoExposure> exposures,
                            std::string_view photo);

// The rate at a share of the iterations, from options.start to 1.
double ExposureRate(const ExposureOptions& options, double share);

// Writes the colours of a photograph of `scene` (H x W x 3) to *photo.
void ApplyColor(const AffineColor& color,
                const ImageF& scene,
                ThreadPool& pool,
                ImageF* photo);

// The colours that take those of a photograph back to the scene; the identity
// if nothing does.
AffineColor Inverse(const AffineColor& color);

// From dL/dphoto makes dL/dscene, in place, and returns dL/dcolor. `scene` is
// the input of ApplyColor. The result is the same bytes for any number of
// threads. *scratch is memory that calls can share.
using ColorSums = std::array<double, 12>;
AffineColor BackwardColor(const AffineColor& color,
                          const ImageF& scene,
                          ThreadPool& pool,
                          std::vector<ColorSums>* scratch,
                          ImageF* gradient);

// The colours of all photographs and Adam's moments for them. The mean over
// the photographs stays the identity. Otherwise the scene could become darker
// while all photographs become brighter.
struct PhotoColors {
  struct Entry {
    AffineColor color;
    std::array<float, 12> first_moment = {};
    std::array<float, 12> second_moment = {};
    int64_t steps = 0;

    friend bool operator==(const Entry&, const Entry&) = default;
  };
  std::vector<Entry> entries;  // By photograph; empty: they are not learnt.

  // Makes one step of Adam with the gradient of one photograph's colours.
  void Step(size_t photo,
            const AffineColor& gradient,
            double rate,
            double pull);

  friend bool operator==(const PhotoColors&, const PhotoColors&) = default;
};

// The colours that take the pixels of `scene` to those of `photo` with the
// least squared error, in the columns [begin, end) of both (H x W x 3). Numbers
// that these colours say nothing about stay those of the identity, and so do
// all when there are fewer than 64 pixels. Pixels that `mask` (null: none) has
// as 0 are left out.
AffineColor FitColor(const ImageF& scene,
                     const ImageF& photo,
                     const ImageU8* mask,
                     int begin,
                     int end);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_OPTIM_EXPOSURE_H_
