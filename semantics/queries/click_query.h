// SPDX-License-Identifier: BSD-3-Clause
// Finds the instance that a click or a drawn box means (FreeGS, "Testing":
// interactive prompts). No network takes part: the answer is the label at that
// place.

#ifndef FREEGS_SEMANTICS_QUERIES_CLICK_QUERY_H_
#define FREEGS_SEMANTICS_QUERIES_CLICK_QUERY_H_

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

// Column and row, counted from 0 at the top left.
struct Pixel {
  int x = 0;
  int y = 0;
};

struct ClickHit {
  int id = 0;         // Id of the instance.
  double weight = 0;  // Summed blending weight of its Gaussians at the pixel.
  // Where the ray of the pixel meets the instance: at the mean depth of its
  // Gaussians at the pixel, by weight. In the model frame
  // (splat/scene/model_frame.h).
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

// Returns the instances at a pixel of the view by descending weight, the
// smaller id first among equals. The first one is the label that
// splat::RenderLabels gives to the pixel. Only this pixel is rendered. There
// are no hits if the weights of all instances sum to less than one half.
// labels: for each Gaussian, -1 for none, else id - 1. kInvalidArgument for a
// pixel outside of the image, and for labels of another number of Gaussians.
StatusOr<std::vector<ClickHit>> QueryClick(const splat::GaussianModel& model,
                                           std::span<const int32_t> labels,
                                           const View& view,
                                           const splat::RenderOptions& render,
                                           const Pixel& pixel,
                                           ThreadPool& pool);

struct BoxHit {
  int id = 0;      // Id of the instance.
  double iou = 0;  // Between the drawn box and that of the instance.
};

// The corners of a box in pixels. Pixel (x, y) covers [x, x + 1) x [y, y + 1).
struct PixelBox {
  double x0 = 0, y0 = 0;
  double x1 = 0, y1 = 0;
};

struct BoxQueryOptions {
  // Whether large planes (floor, walls, table tops) may be hits.
  bool background = false;
};

// Returns the instances with a pixel in the box, by descending IoU of the box
// and the box around the instance's pixels; the smaller id first among equals.
// People draw boxes tightly around what they mean. How much of the box an
// instance fills is no good measure: a fork fills almost nothing of it, and
// what lies behind fills it too. The box around an instance is that of its
// visible pixels, and leaves out 1 % of them on each side as strays.
//
// label_image: the labels of the view, as splat::RenderLabels returns them.
// box: may be drawn from any corner and is cut at the borders of the image.
// is_background: by label; labels beyond its end are no background.
// kInvalidArgument if nothing of the box lies in the image, or a number is not
// finite.
StatusOr<std::vector<BoxHit>> QueryBox(
    const Image<int32_t>& label_image,
    const PixelBox& box,
    const BoxQueryOptions& options,
    std::span<const uint8_t> is_background = {});

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_QUERIES_CLICK_QUERY_H_
