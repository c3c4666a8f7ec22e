// SPDX-License-Identifier: BSD-3-Clause
// Regions of a scene's surfaces, what is known of each, and what was seen where
// two of them meet. Regions begin as patches and are joined to larger ones; all
// that is kept of them are sums, so that joining them is adding.

#ifndef FREEGS_SEMANTICS_PATCHES_REGION_GRAPH_H_
#define FREEGS_SEMANTICS_PATCHES_REGION_GRAPH_H_

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace freegs::semantics {

inline constexpr int kColorBins = 10;  // For each channel of L*a*b*.

using ColorHistogram = std::array<std::array<float, kColorBins>, 3>;

struct RegionStats {
  // Over the pixels of all views that show the region.
  double pixels = 0;
  // Pairs of neighbouring pixels across its outline, with those across depth
  // steps, also to patches that it hardly touches.
  double perimeter = 0;
  Eigen::Vector3d color = Eigen::Vector3d::Zero();   // Sum of L*a*b* / 100.
  Eigen::Vector3d color2 = Eigen::Vector3d::Zero();  // Sum of its squares.
  ColorHistogram histogram = {};
  // Colours of the region's patches and of those two steps around them, so that
  // the light and the dark parts of one texture look alike.
  ColorHistogram context = {};
  double context_pixels = 0;

  // Sums over its Gaussians, weighted by the pixels that they cover: of the
  // weights, of the positions x in the model frame, and of x x^T.
  double weight = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d position2 = Eigen::Matrix3d::Zero();
  std::vector<float> semantics;  // Sum of unit vectors; may be empty.

  void Add(const RegionStats& other);
};

// The best plane of a region's Gaussians, and standard deviations along its
// principal axes. Zeros for a region that nothing was seen of.
struct RegionExtent {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double thickness = 0;  // thickness <= width <= length.
  double width = 0;
  double length = 0;

  // 0 for a plane, 1 for a ball.
  double Flatness() const { return width > 0 ? thickness / width : 0; }
};

// The extent of a region's Gaussians, in the model frame.
RegionExtent ExtentOf(const RegionStats& region);

// The flatness of RegionExtent alone, from the sums of RegionStats: `weight`,
// `position_sum` for `position`, and `outer_product_sum` for `position2`.
double FlatnessOf(double weight,
                  const Eigen::Vector3d& position_sum,
                  const Eigen::Matrix3d& outer_product_sum);

// Adds each bin of `from` to the same bin of `to`.
void AddHistogram(const ColorHistogram& from, ColorHistogram* to);

struct ContactStats {
  // Over the pairs of neighbouring pixels, one in each region, in all views.
  double pixels = 0;         // Where the depth does not jump.
  double hidden = 0;         // Where it does: one region is in front.
  double contrast_near = 0;  // Sums over `pixels` of LocalContrast ...
  double contrast_far = 0;   // ... with a small and a large window.
  double difference = 0;     // Difference of colours, in the small window.
  double depth_step = 0;     // In sizes of patches.

  // Sum over all pairs, `pixels` and `hidden`, of LocalRelief::Step.
  double relief = 0;

  // Sums over `pixels` of what the two patches there have between them.
  double concavity = 0;  // Positive in a concave crease (Stein et al. 2014).
  double bend = 0;       // 1 - cosine between the normals.

  void Add(const ContactStats& other);
};

struct Contact {
  int32_t a = 0;  // a < b.
  int32_t b = 0;
  ContactStats stats;
};

struct RegionGraph {
  std::vector<RegionStats> regions;
  std::vector<Contact> contacts;  // Sorted by (a, b), each pair once.
  double total_pixels = 0;        // Pixels of all views together.

  std::vector<double> PixelsOfRegions() const;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_REGION_GRAPH_H_
