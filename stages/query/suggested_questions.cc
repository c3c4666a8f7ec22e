// SPDX-License-Identifier: BSD-3-Clause

#include "stages/query/suggested_questions.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "core/io/image_io.h"
#include "semantics/instances/instances.h"
#include "semantics/instances/instances_json.h"
#include "semantics/metrics/instance_metrics.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using Question = std::vector<std::string>;

// The ids that a view shows. Those that it shows whole are first, because what
// reaches the edge of a picture is often a wall or a floor; then those of most
// pixels.
std::vector<int> IdsToClick(const ImageU16& map) {
  struct Seen {
    bool at_edge = false;
    int64_t pixels = 0;
  };
  std::map<int, Seen> seen;
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      Seen& region = seen[map(x, y)];
      ++region.pixels;
      region.at_edge = region.at_edge || x == 0 || y == 0 ||
                       x == map.width() - 1 || y == map.height() - 1;
    }
  }
  seen.erase(0);
  std::vector<std::tuple<bool, int64_t, int>> order;
  for (const auto& [id, region] : seen) {
    order.emplace_back(region.at_edge, -region.pixels, id);
  }
  std::sort(order.begin(), order.end());
  std::vector<int> ids;
  for (const auto& entry : order) ids.push_back(std::get<2>(entry));
  return ids;
}

// Asks for what the view shows and is not yet in `asked`.
Status AppendClicks(const fs::path& workspace,
                    int max_questions,
                    std::set<int> asked,
                    std::vector<Question>* questions) {
  FREEGS_ASSIGN_OR_RETURN(const WorkspaceScene scene,
                          ReadWorkspaceScene(workspace));
  std::vector<View> views = scene.train;
  views.insert(views.end(), scene.holdout.begin(), scene.holdout.end());
  if (views.empty()) return Status();
  const size_t middle = scene.train.size() / 2;
  FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                          OutputNames(views, ".png"));
  FREEGS_ASSIGN_OR_RETURN(
      const ImageU16 map,
      ReadLabels(workspace / "bootstrap" / "instances" / names[middle]));
  for (const int id : IdsToClick(map)) {
    if (static_cast<int>(questions->size()) >= max_questions) break;
    if (!asked.insert(id).second) continue;
    const auto point = semantics::ClickPoint(map, id);
    questions->push_back({"--click",
                          views[middle].name,
                          std::to_string(point->x()),
                          std::to_string(point->y())});
  }
  return Status();
}

}  // namespace

StatusOr<std::vector<Question>> SuggestQuestions(const fs::path& workspace,
                                                 int max_questions) {
  FREEGS_ASSIGN_OR_RETURN(
      std::vector<semantics::Instance> instances,
      semantics::ReadInstances(workspace / "bootstrap" / "instances.json"));
  std::stable_sort(
      instances.begin(), instances.end(), [](const auto& a, const auto& b) {
        return a.num_gaussians > b.num_gaussians;
      });
  std::vector<Question> questions;
  std::set<std::string> texts;
  std::set<int> asked;
  for (const semantics::Instance& instance : instances) {
    if (instance.background) asked.insert(instance.id);
    if (instance.background || instance.words.empty() ||
        static_cast<int>(questions.size()) + 1 >= max_questions ||
        !texts.insert(instance.words[0]).second) {
      continue;
    }
    asked.insert(instance.id);
    questions.push_back({"--text", instance.words[0]});
  }
  FREEGS_RETURN_IF_ERROR(
      AppendClicks(workspace, max_questions, std::move(asked), &questions));
  return questions;
}

}  // namespace freegs::stages
