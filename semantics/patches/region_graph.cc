// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/region_graph.h"

namespace freegs::semantics {

void RegionStats::Add(const RegionStats& other) {
  pixels += other.pixels;
  perimeter += other.perimeter;
  color += other.color;
  color2 += other.color2;
  for (size_t c = 0; c < histogram.size(); ++c) {
    for (size_t k = 0; k < histogram[c].size(); ++k) {
      histogram[c][k] += other.histogram[c][k];
    }
  }
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
