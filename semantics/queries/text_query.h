// SPDX-License-Identifier: BSD-3-Clause
// Which instances a text or an example picture means: match by proposal
// (FreeGS, "Testing"). A query is compared once with one feature per instance,
// whatever the number of views.

#ifndef FREEGS_SEMANTICS_QUERIES_TEXT_QUERY_H_
#define FREEGS_SEMANTICS_QUERIES_TEXT_QUERY_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/status.h"
#include "semantics/queries/instance_features.h"

namespace freegs::semantics {

struct TextHit {
  int id = 0;            // Instance.
  double relevancy = 0;  // See clip/relevancy.h; one half is indifference.
  double cosine = 0;     // Of feature and text.
};

struct ExampleHit {
  int id = 0;         // Instance.
  double cosine = 0;  // Of feature and picture.
};

struct TextQueryOptions {
  // Instances of less relevancy are not hits; without any, what was asked for
  // is not here. From one half on the instance is more like the text than like
  // each of the encoder's canonical phrases. It says no more than that:
  // relevancies of a small encoder lie close together, so that something of the
  // wrong kind may pass, and a word that the encoder never learnt may be
  // relevant anywhere. What is known about an encoder's own answers is better
  // said with another threshold.
  double min_relevancy = 0.5;

  // At most so many hits, the best; 0 is no limit.
  int max_hits = 0;

  // Whether instances that are large planes (floor, walls, table tops) may
  // answer too.
  bool background = false;

  Status Check() const;
};

struct ExampleQueryOptions {
  int max_hits = 0;         // As above.
  bool background = false;  // As above.

  Status Check() const;
};

// The instances by descending relevancy of their features to the text; ties by
// id. Instances of which nothing is known are left out.
//
// text: of size features.dim and length 1. canonical: texts likewise, one after
// another; as the phrases of clip/relevancy.h. is_background: per instance (row
// of the features); empty where no instance is. kInvalidArgument for sizes that
// disagree and for vectors that are not finite.
StatusOr<std::vector<TextHit>> QueryText(
    const InstanceFeatures& features,
    std::span<const float> text,
    std::span<const float> canonical,
    const TextQueryOptions& options,
    std::span<const uint8_t> is_background = {});

// The same by descending cosine with a picture's vector (not zero, of any
// length).
StatusOr<std::vector<ExampleHit>> QueryExample(
    const InstanceFeatures& features,
    std::span<const float> image_vector,
    const ExampleQueryOptions& options,
    std::span<const uint8_t> is_background = {});

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_QUERIES_TEXT_QUERY_H_
