// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/region_graph.h"

namespace freegs::semantics {

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
  for (size_t k = 0; k < semantics.size(); ++k) {
    semantics[k] += other.semantics[k];
  }
}

void ContactStats::Add(const ContactStats& other) {
  pixels += other.pixels;
  hidden += other.hidden;
  contrast_near += other.contrast_near;
  contrast_far += other.contrast_far;
  difference += other.difference;
  depth_step += other.depth_step;
  points += other.points;
  concavity += other.concavity;
  bend += other.bend;
}

}  // namespace freegs::semantics
