// SPDX-License-Identifier: BSD-3-Clause

#include "stages/query/query_session.h"

#include <sstream>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "stages/query/file_stamp.h"
#include "stages/query/lap.h"
#include "stages/query/query_answer.h"

namespace freegs::stages {

StatusOr<nlohmann::json> QuerySession::Ask(QueryRequest request,
                                           ThreadPool& pool) {
  Lap lap;
  request.workspace = workspace_;
  const std::string stamp = QueryStamp(workspace_);
  if (stamp != stamp_) {
    scene_ = {};
    networks_ = {};
  }
  // Until the answer is there: if memory runs out in between, the next question
  // reads everything again.
  stamp_.clear();
  std::ostringstream messages;
  const Status loaded = LoadQueryScene(request, messages, &scene_);
  if (!loaded.ok()) {
    // What was read before the fault has not been compared with the rest.
    scene_ = {};
    stamp_ = stamp;
    return loaded;
  }
  const double load_ms = lap.Milliseconds();

  // Another level takes Gaussians from their instances, for one answer.
  std::vector<int32_t> labels;
  if (request.level) labels = scene_.labels;
  const size_t num_instances = scene_.instances.size();
  StatusOr<QueryAnswer> answer = FindAnswer(request, pool, &scene_, &networks_);
  nlohmann::json json;
  if (answer.ok()) {
    answer->load_ms = load_ms;
    answer->note = messages.str() + answer->note;
    json = ToJson(*answer, scene_.instances);
  }
  if (request.level) {
    scene_.labels = std::move(labels);
    scene_.instances.resize(num_instances);
  }
  stamp_ = stamp;
  if (!answer.ok()) return answer.status();
  return json;
}

}  // namespace freegs::stages
