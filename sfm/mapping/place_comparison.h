// SPDX-License-Identifier: BSD-3-Clause
// Tells which photos several models of the same photos put in the same place.

#ifndef FREEGS_SFM_MAPPING_PLACE_COMPARISON_H_
#define FREEGS_SFM_MAPPING_PLACE_COMPARISON_H_

#include <cstddef>
#include <string>
#include <vector>

#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// Names of photos that both models have, ascending.
struct PlaceComparison {
  std::vector<std::string> alike;
  std::vector<std::string> elsewhere;
};

// Compares the poses of two models, whose worlds differ by an unknown
// similarity. It is the one that puts most photos of `model` where `other` has
// them: turned by at most 5 degrees, and with the centre within 5 % of the
// scene's size. The size is the upper quartile of the distances of the centres
// in `other` from their median. All pairs of cameras are tried: one gives the
// rotation and the place, both give the scale. So a few photos in a wrong place
// do not disturb the comparison, as they would with least squares.
//
// Both lists are empty if the models have fewer than three photos in common, or
// if all centres of a model coincide. The time grows with the cube of the
// number of photos; 50 take some milliseconds.
PlaceComparison ComparePlaces(const Reconstruction& model,
                              const Reconstruction& other);

// What several models agree on. Each other model that has a photo, too, votes
// for its place or against it. A model is a witness of another one if it has at
// least four fifths of that one's photos in the same place.
struct Consensus {
  // The model with most photos whose place has a vote and is not uncertain;
  // among equal ones that with most votes, and then the first.
  size_t best = 0;

  // Names of photos of that model, ascending, that a witness has elsewhere, or
  // for whose place fewer models vote than against it.
  std::vector<std::string> uncertain;

  // Whether it has a witness.
  bool witnessed = false;
};

// There must be models.
Consensus FindConsensus(const std::vector<Reconstruction>& models);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_PLACE_COMPARISON_H_
