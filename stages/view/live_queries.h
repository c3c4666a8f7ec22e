// SPDX-License-Identifier: BSD-3-Clause
// Questions of pages: one is answered at a time, and not too many wait.

#ifndef FREEGS_STAGES_VIEW_LIVE_QUERIES_H_
#define FREEGS_STAGES_VIEW_LIVE_QUERIES_H_

#include <filesystem>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "core/parallel.h"
#include "stages/query/query_request.h"
#include "stages/query/query_session.h"
#include "stages/view/http_message.h"
#include "stages/view/turns.h"

namespace freegs::stages {

// Several threads may use it.
class LiveQueries {
 public:
  // `defaults` holds the options that a question does not give itself.
  // `max_questions`: the one that is answered and those that wait.
  LiveQueries(const std::filesystem::path& workspace,
              QueryRequest defaults,
              int max_questions);

  // The answer to the body of POST /api/query; 429 while there are too many.
  HttpResponse Answer(std::string_view body);

 private:
  const QueryRequest defaults_;
  ThreadPool pool_;
  Turns turns_;
  QuerySession session_;  // Asked by the thread that has the turn.
};

// Which questions the workspace can answer, and why not the others: the member
// "queries" of /api/status.
nlohmann::json AnswerableQueries(const std::filesystem::path& workspace);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_LIVE_QUERIES_H_
