// SPDX-License-Identifier: BSD-3-Clause
// How much each Gaussian matters to the pictures. A model is made smaller by
// removing the less important Gaussians (Fang and Wang 2024, Mini-Splatting,
// section 4.2).

#ifndef FREEGS_SPLAT_DENSITY_IMPORTANCE_H_
#define FREEGS_SPLAT_DENSITY_IMPORTANCE_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/pinhole.h"
#include "splat/render/contributions.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

enum class ImportanceMetric {
  // The sum of the blending weights over all views. What covers many pixels
  // counts most. This suits bounded scenes, whose parts are all seen from
  // similar distances.
  kIndoor,

  // The sum, over the views in which the Gaussian has the largest weight at
  // some pixel, of its mean weight per pixel that it touches. What is far away
  // and small in every picture counts as much as what is near. This suits
  // unbounded scenes.
  kOutdoor,
};

// Computes both measures over the views of a scene.
//
//   ImportanceAccumulator accumulator(model.size());
//   for (each view) accumulator.AddView(contributions of the view);
//   accumulator.Importance(ImportanceMetric::kIndoor);
class ImportanceAccumulator {
 public:
  explicit ImportanceAccumulator(size_t num_gaussians);

  // Adds a view; see Rasterizer::Contributions. Every model_index must be below
  // size(). Weights that are not finite or not above 0 add nothing.
  void AddView(const ViewContributions& contributions);

  // Returns one number per Gaussian, 0 or more. Numbers of different metrics
  // cannot be compared. A Gaussian that never had the largest weight at any
  // pixel of any view has importance 0.
  std::vector<float> Importance(ImportanceMetric metric) const;

  size_t size() const { return indoor_.size(); }

 private:
  std::vector<double> indoor_;
  std::vector<double> outdoor_;
  std::vector<uint8_t> ever_dominant_;
};

// Returns the metric that suits a scene: kOutdoor when at least a tenth of the
// Gaussians lie farther than 5 lengths from the middle of the cameras, else
// kIndoor. The middle is the median of the camera centres, axis by axis. The
// length is the larger of two numbers, neither of which a few stray cameras or
// Gaussians can change much:
// - the median distance of a camera from the middle, such as the radius of a
//   ring of cameras around an object;
// - the distance within which a quarter of the Gaussians lie. It decides when
//   the cameras stand close together, so that their spread says nothing.
//
// The walls behind an object, or around somebody who stands in a room, are 2 to
// 4 lengths away; outdoors much of the background is 10 lengths away or more.
// Floaters, and what is seen through a window, are less than a tenth of the
// Gaussians; the background of an open scene is more. A courtyard or a hall may
// get either metric, and both serve it. Gaussians that are not finite do not
// count. Without views or Gaussians the metric is kIndoor.
ImportanceMetric ChooseImportanceMetric(std::span<const View> views,
                                        const GaussianModel& model);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_DENSITY_IMPORTANCE_H_
