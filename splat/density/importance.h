// SPDX-License-Identifier: BSD-3-Clause
// How much each Gaussian matters to the pictures: the measure by which a model
// is made smaller (Fang and Wang 2024, Mini-Splatting, section 4.2).

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
  // Sum over the views of the blending weights: what covers many pixels counts
  // most. For bounded scenes, whose parts are seen from similar distances.
  kIndoor,

  // Sum over the views that it dominates somewhere of the mean weight per pixel
  // touched: what is far and small in every picture counts as much as what is
  // near. For unbounded scenes.
  kOutdoor,
};

// Collects both measures over the views of a scene. Sums in double, so the
// order of the views changes the result by rounding only.
class ImportanceAccumulator {
 public:
  explicit ImportanceAccumulator(size_t num_gaussians);

  // Every model_index must be below size(). Weights that are not finite or not
  // above 0 add nothing.
  void AddView(const ViewContributions& contributions);

  // One number >= 0 per Gaussian, comparable within one metric only. 0 for
  // Gaussians that were never the largest at any pixel of any view.
  std::vector<float> Importance(ImportanceMetric metric) const;

  size_t size() const { return indoor_.size(); }

 private:
  std::vector<double> indoor_;
  std::vector<double> outdoor_;
  std::vector<uint8_t> ever_dominant_;
};

// The metric that suits a scene: kOutdoor when at least kFarShare of the
// Gaussians lie farther than kFarFactor lengths from the middle of the cameras.
// The middle is the median of the camera centres, axis by axis. The length is
// the larger of two, both robust to stray cameras and Gaussians:
// - the median distance of a camera from the middle: the radius of a ring
//   around an object, or the reach of a walk through a room;
// - the distance that a quarter of the Gaussians stay within: how near the near
//   content is. It takes over where the cameras lie together and their spread
//   says nothing.
// A factor of 5: the walls behind a ringed object, or around somebody who
// stands in a room, are 2 to 4 lengths away; of what lies beyond under the open
// sky much is 10 or more. A share of a tenth: floaters and a window are less,
// the background of an open scene is more. Gaussians that are not finite do not
// count. kIndoor without views or Gaussians. The middle ground (a courtyard, a
// hall) may fall to either; both metrics serve it.
ImportanceMetric ChooseImportanceMetric(std::span<const View> views,
                                        const GaussianModel& model);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_DENSITY_IMPORTANCE_H_
