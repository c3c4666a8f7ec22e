// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/region_graph.h"

#include <algorithm>

#include <Eigen/Eigenvalues>

namespace freegs::semantics {

namespace {

// Principal axes of positions whose sums are given, the shortest first.
Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> AxesOf(
    double weight,
    const Eigen::Vector3d& position_sum,
    const Eigen::Matrix3d& outer_product_sum,
    Eigen::DecompositionOptions what) {
  const Eigen::Vector3d centre = position_sum / weight;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(outer_product_sum / weight - centre * centre.transpose(),
                       what);
  return solver;
}

Eigen::Vector3d DeviationsOf(
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>& axes) {
  return axes.eigenvalues().cwiseMax(0.0).cwiseSqrt();
}

}  // namespace

RegionExtent ExtentOf(const RegionStats& region) {
  RegionExtent extent;
  if (!(region.weight > 0)) return extent;
  const auto axes = AxesOf(region.weight,
                           region.position,
                           region.position2,
                           Eigen::ComputeEigenvectors);
  const Eigen::Vector3d deviations = DeviationsOf(axes);
  extent.centre = region.position / region.weight;
  extent.normal = axes.eigenvectors().col(0);
  extent.thickness = deviations[0];
  extent.width = deviations[1];
  extent.length = deviations[2];
  return extent;
}

double FlatnessOf(double weight,
                  const Eigen::Vector3d& position_sum,
                  const Eigen::Matrix3d& outer_product_sum) {
  RegionExtent extent;
  if (!(weight > 0)) return extent.Flatness();
  const Eigen::Vector3d deviations = DeviationsOf(
      AxesOf(weight, position_sum, outer_product_sum, Eigen::EigenvaluesOnly));
  extent.thickness = deviations[0];
  extent.width = deviations[1];
  return extent.Flatness();
}

void AddHistogram(const ColorHistogram& from, ColorHistogram* to) {
  for (size_t c = 0; c < from.size(); ++c) {
    for (size_t k = 0; k < from[c].size(); ++k) (*to)[c][k] += from[c][k];
  }
}

void RegionStats::Add(const RegionStats& other) {
  pixels += other.pixels;
  perimeter += other.perimeter;
  color += other.color;
  color2 += other.color2;
  AddHistogram(other.histogram, &histogram);
  AddHistogram(other.context, &context);
  context_pixels += other.context_pixels;
  weight += other.weight;
  position += other.position;
  position2 += other.position2;
  semantics.resize(std::max(semantics.size(), other.semantics.size()), 0.0f);
  for (size_t k = 0; k < other.semantics.size(); ++k) {
    semantics[k] += other.semantics[k];
  }
}

std::vector<double> RegionGraph::PixelsOfRegions() const {
  std::vector<double> pixels;
  for (const RegionStats& region : regions) pixels.push_back(region.pixels);
  return pixels;
}

void ContactStats::Add(const ContactStats& other) {
  pixels += other.pixels;
  hidden += other.hidden;
  contrast_near += other.contrast_near;
  contrast_far += other.contrast_far;
  difference += other.difference;
  depth_step += other.depth_step;
  relief += other.relief;
  concavity += other.concavity;
  bend += other.bend;
}

}  // namespace freegs::semantics
