// SPDX-License-Identifier: BSD-3-Clause

#include "stages/query/query_answer.h"

#include <algorithm>
#include <array>
#include <string>
#include <tuple>
#include <utility>

#include "core/number_text.h"
#include "core/text.h"
#include "semantics/instances/instances_json.h"

namespace freegs::stages {
namespace {

using nlohmann::json;

// So many instances are listed after the hits.
constexpr size_t kMaxOthers = 5;

const semantics::Instance& InstanceOf(
    const ScoredInstance& scored,
    const std::vector<semantics::Instance>& instances) {
  return *std::find_if(
      instances.begin(), instances.end(), [&](const auto& instance) {
        return instance.id == scored.id;
      });
}

json Brief(const ScoredInstance& scored) {
  return {{"id", scored.id}, {"score", scored.score}};
}

// The instance as in instances.json, except that "score" is that of the answer
// and the instance's own score is "instance_score".
json HitToJson(const ScoredInstance& hit, const semantics::Instance& instance) {
  json entry = semantics::InstanceToJson(instance);
  entry["instance_score"] = entry["score"];
  entry["score"] = hit.score;
  if (hit.cosine) entry["cosine"] = *hit.cosine;
  if (hit.point) {
    entry["point"] = {hit.point->x(), hit.point->y(), hit.point->z()};
  }
  return entry;
}

const ScoredInstance* Best(const QueryAnswer& answer) {
  if (!answer.hits.empty()) return &answer.hits[0];
  return answer.others.empty() ? nullptr : &answer.others[0];
}

std::string Triple(const Eigen::Vector3d& x, int decimals) {
  return FormatFixed(x[0], decimals) + " " + FormatFixed(x[1], decimals) + " " +
         FormatFixed(x[2], decimals);
}

void PrintNotFound(const QueryAnswer& answer, std::ostream& out) {
  out << "not found: " << answer.words;
  if (const ScoredInstance* best = Best(answer)) {
    const int decimals = DecimalsApart(best->score, answer.threshold, 3);
    out << "; the nearest is instance " << best->id << " with "
        << answer.score_name << " " << FormatFixed(best->score, decimals)
        << ", less than " << FormatFixed(answer.threshold, decimals);
  }
  out << "\n";
}

using Row = std::array<std::string, 6>;

// Prints columns as wide as they need, with two blanks between them. The first
// three are numbers, which end at the same place.
void PrintRows(const std::vector<Row>& rows, std::ostream& out) {
  constexpr size_t kNumbers = 3;
  std::array<size_t, std::tuple_size_v<Row>> widths = {};
  for (const Row& row : rows) {
    for (size_t c = 0; c < row.size(); ++c) {
      widths[c] = std::max(widths[c], row[c].size());
    }
  }
  for (const Row& row : rows) {
    for (size_t c = 0; c < row.size(); ++c) {
      const std::string blanks(widths[c] - row[c].size(), ' ');
      out << "  ";
      if (c < kNumbers) out << blanks;
      out << row[c];
      if (c >= kNumbers && c + 1 < row.size()) out << blanks;
    }
    out << "\n";
  }
}

void PrintHits(const QueryAnswer& answer,
               const std::vector<semantics::Instance>& instances,
               std::ostream& out) {
  out << "found: " << answer.words << "\n";
  std::vector<Row> rows = {{"id",
                            answer.score_name,
                            "Gaussians",
                            "centre",
                            "size of oriented box",
                            "words"}};
  for (const ScoredInstance& hit : answer.hits) {
    const semantics::Instance& instance = InstanceOf(hit, instances);
    // A scene may lie far from the origin of its world, or be small in its
    // unit.
    const int decimals = DecimalsFor(instance.obb.size.maxCoeff());
    rows.push_back({std::to_string(hit.id),
                    FormatFixed(hit.score, 3),
                    std::to_string(instance.num_gaussians),
                    Triple(instance.centre, decimals),
                    Triple(instance.obb.size, decimals),
                    Joined(instance.words) +
                        (instance.background ? " (large plane)" : "")});
  }
  PrintRows(rows, out);
}

}  // namespace

void SplitHits(const std::vector<ScoredInstance>& scored,
               int max_hits,
               QueryAnswer* answer) {
  size_t count = 0;
  while (count < scored.size() && scored[count].score >= answer->threshold &&
         (max_hits == 0 || count < static_cast<size_t>(max_hits))) {
    ++count;
  }
  const size_t end = std::min(scored.size(), count + kMaxOthers);
  answer->hits.assign(scored.begin(),
                      scored.begin() + static_cast<int64_t>(count));
  answer->others.assign(scored.begin() + static_cast<int64_t>(count),
                        scored.begin() + static_cast<int64_t>(end));
}

json ToJson(const QueryAnswer& answer,
            const std::vector<semantics::Instance>& instances) {
  json hits = json::array();
  for (const ScoredInstance& hit : answer.hits) {
    hits.push_back(HitToJson(hit, InstanceOf(hit, instances)));
  }
  json others = json::array();
  for (const ScoredInstance& other : answer.others) {
    others.push_back(Brief(other));
  }
  // A part or whole of what was clicked may weigh less than another instance.
  double best_score = -1;
  for (const auto* list : {&answer.hits, &answer.others}) {
    for (const ScoredInstance& scored : *list) {
      best_score = std::max(best_score, scored.score);
    }
  }
  const bool compared = Best(answer) != nullptr;
  json result = {{"query", answer.question},
                 {"found", !answer.hits.empty()},
                 {"score", answer.score_name},
                 {"threshold", answer.threshold},
                 {"best_score", compared ? json(best_score) : json(nullptr)},
                 {"hits", std::move(hits)},
                 {"others", std::move(others)},
                 {"plane", answer.plane ? Brief(*answer.plane) : json(nullptr)},
                 {"note", answer.note},
                 {"timings",
                  {{"load_ms", answer.load_ms},
                   {"encode_ms", answer.encode_ms},
                   {"query_ms", answer.query_ms},
                   {"masks_ms", answer.masks_ms}}}};
  if (answer.masks) {
    json masks = json::array();
    for (const MaskedView& view : *answer.masks) {
      masks.push_back(
          {{"view", view.name}, {"mask", view.mask}, {"pixels", view.pixels}});
    }
    result["masks"] = std::move(masks);
  }
  return result;
}

void PrintAnswer(const QueryAnswer& answer,
                 const std::vector<semantics::Instance>& instances,
                 std::ostream& out) {
  if (answer.hits.empty()) {
    PrintNotFound(answer, out);
  } else {
    PrintHits(answer, instances, out);
    for (size_t k = 0; k < answer.others.size(); ++k) {
      out << (k == 0 ? "next: " : ", ") << answer.others[k].id << " ("
          << FormatFixed(answer.others[k].score, 3) << ")";
    }
    if (!answer.others.empty()) out << "\n";
    if (answer.question.contains("level")) {
      out << answer.hits[0].id
          << " is not one of the scene's instances, so --only does not know "
             "it\n";
    }
  }
  if (answer.plane && answer.plane->score >= answer.threshold) {
    out << "the large plane " << answer.plane->id << " has "
        << answer.score_name << " " << FormatFixed(answer.plane->score, 3)
        << "; --background lets planes answer\n";
  }
  if (answer.masks) {
    const auto seen = std::count_if(
        answer.masks->begin(), answer.masks->end(), [](const MaskedView& view) {
          return view.pixels > 0;
        });
    out << answer.masks->size() << " masks, " << seen << " of them not empty\n";
  }
}

}  // namespace freegs::stages
