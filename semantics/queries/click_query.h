// SPDX-License-Identifier: BSD-3-Clause
// Which instance a click or a drawn box means (FreeGS, "Testing": interactive
// prompts). No network takes part: the answer is the label that lies there.

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

struct ClickHit {
  int id = 0;         // Instance.
  double weight = 0;  // Summed blending weight of its Gaussians at the pixel.
  // Where the pixel's ray meets it: at the mean depth of its Gaussians there,
  // by weight. World frame.
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

// The instances at pixel (x, y) of the camera by descending weight, ties by id:
// the first is the pixel's label in splat::RenderLabels. Only that pixel is
// blended. labels: per Gaussian, -1 for none, else id - 1. kInvalidArgument for
// a pixel outside the image and for labels of another number than the
// Gaussians.
StatusOr<std::vector<ClickHit>> QueryClick(const splat::GaussianModel& model,
                                           std::span<const int32_t> labels,
                                           const Pinhole& camera,
                                           const Rigid3d& cam_from_world,
                                           const splat::RenderOptions& render,
                                           int x,
                                           int y,
                                           ThreadPool& pool);

struct BoxHit {
  int id = 0;      // Instance.
  double iou = 0;  // Of the drawn box and the box around the instance's pixels.
};

// Corners in pixels: pixel (x, y) covers [x, x + 1) x [y, y + 1).
struct PixelBox {
  double x0 = 0, y0 = 0;
  double x1 = 0, y1 = 0;
};

struct BoxQueryOptions {
  // Whether large planes (floor, walls, table tops) may be meant too.
  bool background = false;
};

// The instances with a pixel in the box by descending IoU, ties by id. People
// draw boxes tightly around what they mean; how much of the box it fills says
// little (a fork fills none of it), and what lies behind fills it too, but is
// larger. What is partly hidden is compared as far as it is seen.
//
// label_image: of the view, as splat::RenderLabels gives it. The box may be
// drawn from any corner and is cut at the image's edges; kInvalidArgument when
// nothing is left of it or a number is not finite. is_background: by label;
// empty where no instance is, and labels beyond its end are not.
StatusOr<std::vector<BoxHit>> QueryBox(
    const Image<int32_t>& label_image,
    const PixelBox& box,
    const BoxQueryOptions& options,
    std::span<const uint8_t> is_background = {});

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_QUERIES_CLICK_QUERY_H_
