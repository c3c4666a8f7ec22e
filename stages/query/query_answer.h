// SPDX-License-Identifier: BSD-3-Clause
// The answer of a query: which instances, how sure, and in which views they are
// seen; as JSON and as a table.

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
  double score = 0;
  std::optional<double> cosine;  // Of text and example.
  // Of a click: where it meets the instance, world frame.
  std::optional<Eigen::Vector3d> point;
};

struct MaskedView {
  std::string name;  // Of the view.
  std::string mask;  // File, relative to the folder of the answer.
  int64_t pixels = 0;
};

struct QueryAnswer {
  nlohmann::json question;  // {"kind": "text", "text": "red apple"}
  std::string words;        // The same for people: text "red apple"
  std::string score_name;   // "relevancy", "cosine", "weight" or "iou".
  double threshold = 0;     // Scores below are no hits.

  // By descending score: the hits are at least the threshold, at most as many
  // as were asked for; others follow them.
  std::vector<ScoredInstance> hits;
  std::vector<ScoredInstance> others;
  // A large plane, not asked for, of a higher score than all.
  std::optional<ScoredInstance> plane;

  std::optional<std::vector<MaskedView>> masks;  // Where they were written.

  // Milliseconds: reading files; the network, with loading it; finding the
  // answer; drawing masks.
  double load_ms = 0;
  double encode_ms = 0;
  double query_ms = 0;
  double masks_ms = 0;
};

// Cuts a list by descending score into hits and others: at most max_hits (0: no
// limit) of at least answer->threshold, and the next few.
void SplitHits(const std::vector<ScoredInstance>& scored,
               int max_hits,
               QueryAnswer* answer);

// The fields are in docs/queries.md. `instances` holds every hit.
nlohmann::json ToJson(const QueryAnswer& answer,
                      const std::vector<semantics::Instance>& instances);

void PrintAnswer(const QueryAnswer& answer,
                 const std::vector<semantics::Instance>& instances,
                 std::ostream& out);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_QUERY_QUERY_ANSWER_H_
