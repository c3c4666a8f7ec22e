// SPDX-License-Identifier: BSD-3-Clause
// What speaks for or against two regions being one thing.

#ifndef FREEGS_SEMANTICS_PATCHES_EVIDENCE_H_
#define FREEGS_SEMANTICS_PATCHES_EVIDENCE_H_

#include <array>
#include <cstddef>
#include <vector>

#include "semantics/patches/region_graph.h"

namespace freegs::semantics {

// All are pure numbers, mostly in [0, 1], and do not depend on the scale of the
// scene, the size of the images or the number of views. "Small" and "large" are
// the two regions by the pixels that show them.
enum EvidenceKind : size_t {
  kContrastNear,   // Boundary in the photographs, narrow windows.
  kContrastFar,    // Boundary in the photographs, wide windows.
  kStep,           // Difference of colour across the boundary.
  kContext,        // Distance of the colour histograms around the regions.
  kDepthStep,      // Steps of depth along the boundary.
  kRelief,         // Steps of planes fitted to both sides of it.
  kHidden,         // Share of it where one region hides the other.
  kColor,          // Difference of the mean colours.
  kColorContrast,  // kColor relative to the spread of colours.
  kHistogram,      // Distance of the regions' own colour histograms.
  kLikeness,       // exp(-kHistogram / 0.15): differences beyond count alike.
  kLikenessAb,     // kLikeness of a and b alone, without light and shade.
  kSpread,         // Difference of the spreads of colours.
  kConcave,        // Crease that is concave, as where things touch.
  kConvex,         // Crease that is convex, as on a box.
  kBend,           // Angle between the surfaces.
  kInterleaved,    // Share of the longer outline that both have in common.
  kEnclosed,       // Share of the shorter outline that both have in common.
  kSize,           // log10 of the small region's share of all pixels.
  kFlatSmall,      // Flatness: 0 for a plane, 1 for a ball.
  kFlatLarge,
  kFlatBoth,   // Flatness of both together.
  kOffPlane,   // Distance of the small region from the plane of the large one.
  kSemantics,  // 1 - cosine of the mean semantic vectors.
  kNumEvidences,
};

// Names in files, in this order.
inline constexpr std::array<const char*, kNumEvidences> kEvidenceNames = {
    "contrast_near",  "contrast_far", "step",      "context",
    "depth_step",     "relief",       "hidden",    "color",
    "color_contrast", "histogram",    "likeness",  "likeness_ab",
    "spread",         "concave",      "convex",    "bend",
    "interleaved",    "enclosed",     "size",      "flat_small",
    "flat_large",     "flat_both",    "off_plane", "semantics"};

using Evidence = std::array<float, kNumEvidences>;

struct MeasuredRegion {
  const RegionStats& stats;
  const RegionExtent& extent;  // ExtentOf the stats.
};

// Symmetric in the two regions. total_pixels: see RegionGraph.
Evidence MeasureEvidence(const MeasuredRegion& a,
                         const MeasuredRegion& b,
                         const ContactStats& contact,
                         double total_pixels);

// Returns the evidence of every contact of `graph`, in the order of
// graph.contacts.
std::vector<Evidence> EvidenceOfContacts(const RegionGraph& graph);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_EVIDENCE_H_
