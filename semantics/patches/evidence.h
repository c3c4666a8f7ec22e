// SPDX-License-Identifier: BSD-3-Clause
// What speaks for or against two regions being one thing.

#ifndef FREEGS_SEMANTICS_PATCHES_EVIDENCE_H_
#define FREEGS_SEMANTICS_PATCHES_EVIDENCE_H_

#include <array>

#include "semantics/patches/region_graph.h"

namespace freegs::semantics {

// All are pure numbers, mostly in [0, 1], and do not depend on the scale of the
// scene, the size of the images or the number of views.
inline constexpr std::array<const char*, 22> kEvidenceNames = {
    "contrast_near",   // Boundary in the photographs, narrow windows.
    "contrast_far",    // The same, wide windows.
    "step",            // Difference of colour across the boundary.
    "context",         // Distance of the colour histograms around them.
    "depth_step",      // Steps of depth along it.
    "hidden",          // Share of it where one region hides the other.
    "color",           // Difference of the mean colours.
    "color_contrast",  // The same, relative to the spread of colours.
    "histogram",       // Distance of the colour histograms.
    "spread",          // Difference of the spreads of colours.
    "concave",         // Crease that is concave, as where things touch.
    "convex",          // Crease that is convex, as on a box.
    "bend",            // Angle between the surfaces.
    "interleaved",     // Share of the longer outline that is shared.
    "size_small",      // log10 of the share of all pixels.
    "size_large",
    "enclosed",    // Share of the small region's outline that is shared.
    "flat_small",  // Flatness: 0 for a plane, 1 for a ball.
    "flat_large",
    "flat_both",  // Of both together.
    "off_plane",  // The small region's distance from the large one's
                  // plane.
    "semantics",  // 1 - cosine of the mean semantic vectors.
};
inline constexpr size_t kNumEvidences = kEvidenceNames.size();

using Evidence = std::array<float, kNumEvidences>;

// Symmetric in the two regions. total_pixels: see RegionGraph.
Evidence MeasureEvidence(const RegionStats& a,
                         const RegionStats& b,
                         const ContactStats& contact,
                         double total_pixels);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_EVIDENCE_H_
