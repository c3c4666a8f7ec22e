// SPDX-License-Identifier: BSD-3-Clause
// Finds the instances that a text or an example picture means (FreeGS,
// "Testing": match by proposal). A query is compared with one vector per
// instance, whatever the number of views.
//
//   FREEGS_ASSIGN_OR_RETURN(const InstanceFeatures features,
//                           ReadInstanceFeatures(path));
//   FREEGS_ASSIGN_OR_RETURN(const TextEmbedding text,
//                           encoder.EncodeText("a red mug"));
//   FREEGS_ASSIGN_OR_RETURN(const std::vector<float> canonical,
//                           EncodeCanonicalPhrases(encoder));
//   FREEGS_ASSIGN_OR_RETURN(
//       const std::vector<TextHit> hits,
//       QueryText(features, text.values, canonical, TextQueryOptions()));

#ifndef FREEGS_SEMANTICS_QUERIES_TEXT_QUERY_H_
#define FREEGS_SEMANTICS_QUERIES_TEXT_QUERY_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/status.h"
#include "semantics/queries/instance_features.h"

namespace freegs::semantics {

struct TextHit {
  int id = 0;            // Id of the instance.
  double relevancy = 0;  // See clip/relevancy.h.
  double cosine = 0;     // Between the vectors of instance and text.
};

struct ExampleHit {
  int id = 0;         // Id of the instance.
  double cosine = 0;  // Between the vectors of instance and picture.
};

struct TextQueryOptions {
  // Instances of less relevancy are not hits. If there is no hit, the scene
  // does not have what the text says. From one half on, an instance is more
  // like the text than like each of the canonical phrases of the encoder. This
  // says no more than it does: the relevancies of a small encoder lie close
  // together, so that a wrong thing may pass, and a word that the encoder never
  // learnt may be relevant to anything. Another threshold may suit a particular
  // encoder better.
  double min_relevancy = 0.5;

  // The largest number of hits; the best ones are returned. 0 is no limit.
  int max_hits = 0;

  // Whether large planes (floor, walls, table tops) may be hits.
  bool background = false;

  Status Check() const;
};

// As in TextQueryOptions. There is no threshold: cosines between pictures
// differ from model to model, so that instances are only put in order.
struct ExampleQueryOptions {
  int max_hits = 0;
  bool background = false;

  Status Check() const;
};

// Returns the instances by descending relevancy of their vectors to the text;
// the smaller id first among equals. Instances of which nothing is known are
// left out.
//
// text: features.dim numbers, of length 1. canonical: likewise, one vector
// after another; the phrases of clip/relevancy.h. is_background: per instance,
// or empty if none is. kInvalidArgument for sizes that disagree and for vectors
// that are zero or not finite.
StatusOr<std::vector<TextHit>> QueryText(
    const InstanceFeatures& features,
    std::span<const float> text,
    std::span<const float> canonical,
    const TextQueryOptions& options,
    std::span<const uint8_t> is_background = {});

// Returns the instances by descending cosine of their vectors with the vector
// of a picture, which has any length but zero. All else is as in QueryText.
StatusOr<std::vector<ExampleHit>> QueryExample(
    const InstanceFeatures& features,
    std::span<const float> image_vector,
    const ExampleQueryOptions& options,
    std::span<const uint8_t> is_background = {});

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_QUERIES_TEXT_QUERY_H_
