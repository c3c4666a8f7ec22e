// SPDX-License-Identifier: BSD-3-Clause
// Words decide what is one thing: seat and legs of a stool look like two
// things, but together they look more like a stool than the legs alone.

#ifndef FREEGS_SEMANTICS_FIELD_NAMED_WHOLES_H_
#define FREEGS_SEMANTICS_FIELD_NAMED_WHOLES_H_

#include <span>
#include <vector>

#include "semantics/clip/vocabulary.h"
#include "semantics/field/instance_semantics.h"
#include "semantics/instances/instance_pairs.h"

namespace freegs::semantics {

// The words by which an encoder recognises things. A model with no vocabulary,
// or whose confidence nobody has calibrated (0), has no say.
struct KnownThings {
  Vocabulary vocabulary;
  double min_confidence = 0;

  bool have_say() const {
    return vocabulary.num_groups() > 0 && min_confidence > 0;
  }
};

// The pairs that are one thing, which is so if three conditions hold:
// - One of the two alone and both together are taken for the same thing.
// - The relevancy of both together is at least min_confidence.
// - It is larger, by 0.02 at least, than that of either alone.
// alone: a vector for each instance. together: one for each pair.
std::vector<WholePair> FindNamedWholes(std::span<const InstancePair> pairs,
                                       const InstanceVectors& alone,
                                       const InstanceVectors& together,
                                       const KnownThings& things);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_NAMED_WHOLES_H_
