// SPDX-License-Identifier: BSD-3-Clause
// Questions of pages: one is answered at a time, and not too many are taken.

#ifndef FREEGS_STAGES_VIEW_LIVE_QUERIES_H_
#define FREEGS_STAGES_VIEW_LIVE_QUERIES_H_

#include <filesystem>
#include <mutex>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "core/parallel.h"
#include "stages/query/query_request.h"
#include "stages/query/query_session.h"
#include "stages/view/http_message.h"

namespace freegs::stages {

// Several threads may use it.
class LiveQueries {
 public:
  // `defaults` holds the options that a question does not give itself.
  LiveQueries(const std::filesystem::path& workspace, QueryRequest defaults);

  // The answer to the body of POST /api/query.
  HttpResponse Answer(std::string_view body);

 private:
  const QueryRequest defaults_;
  ThreadPool pool_;
  std::mutex mutex_;  // Held while a question is answered.
  QuerySession session_;
};

// Which questions the workspace can answer, and why not the others: the member
// "queries" of /api/status.
nlohmann::json AnswerableQueries(const std::filesystem::path& workspace);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_LIVE_QUERIES_H_
