// SPDX-License-Identifier: BSD-3-Clause
// The answer of a query: which instances were found, their scores, and the
// views in which they are seen. It is printed as JSON or as a table.

#ifndef FREEGS_STAGES_QUERY_QUERY_ANSWER_H_
#define FREEGS_STAGES_QUERY_QUERY_ANSWER_H_

#include <cstdint>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "semantics/instances/instances.h"

namespace freegs::stages {

struct ScoredInstance {
  int id = 0;
  double score = 0;              // What it is says QueryAnswer::score_name.
  std::optional<double> cosine;  // For questions by text and by example.
  // For a click: the surface point that was clicked, in the world frame.
  std::optional<Eigen::Vector3d> point;
};

struct MaskedView {
  std::string name;    // The view's name.
  std::string mask;    // The file, relative to the folder of the answer.
  int64_t pixels = 0;  // Number of pixels in the mask.
};

struct QueryAnswer {
  nlohmann::json question;  // {"kind": "text", "text": "red apple"}
  std::string words;        // The question for people: text "red apple"
  std::string score_name;   // "relevancy", "cosine", "weight" or "iou".
  double threshold = 0;     // An instance of a smaller score is no hit.

  // Both by descending score. The hits reach the threshold and are at most as
  // many as were asked for; the others are the next best instances.
  std::vector<ScoredInstance> hits;
  std::vector<ScoredInstance> others;
  // The best large plane if no other instance has as good a score, when planes
  // were not asked for. It need not reach the threshold.
  std::optional<ScoredInstance> plane;

  // What makes the answer uncertain, in lines for people; empty for nothing.
  std::string note;

  std::optional<std::vector<MaskedView>> masks;  // Nothing without --out.

  // Times in milliseconds.
  double load_ms = 0;    // Reading the workspace.
  double encode_ms = 0;  // Loading and running the CLIP model.
  double query_ms = 0;   // Finding the answer.
  double masks_ms = 0;   // Drawing and writing masks.
};

// Divides `scored`, which is sorted by descending score, into answer->hits and
// answer->others. Hits are the first instances that reach answer->threshold, at
// most max_hits of them (0 is no limit); others are the next few.
void SplitHits(const std::vector<ScoredInstance>& scored,
               int max_hits,
               QueryAnswer* answer);

// docs/queries.md describes the fields. `instances` are those of the workspace
// and must hold every hit.
nlohmann::json ToJson(const QueryAnswer& answer,
                      const std::vector<semantics::Instance>& instances);

void PrintAnswer(const QueryAnswer& answer,
                 const std::vector<semantics::Instance>& instances,
                 std::ostream& out);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_QUERY_QUERY_ANSWER_H_
