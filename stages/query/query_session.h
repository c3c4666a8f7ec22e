// SPDX-License-Identifier: BSD-3-Clause
// Answers many questions about one workspace, for programs that stay: what was
// read for one question is kept for the next.

#ifndef FREEGS_STAGES_QUERY_QUERY_SESSION_H_
#define FREEGS_STAGES_QUERY_QUERY_SESSION_H_

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "core/parallel.h"
#include "core/status.h"
#include "stages/query/query_engine.h"
#include "stages/query/query_request.h"
#include "stages/query/query_scene.h"

namespace freegs::stages {

//   QuerySession session(workspace);
//   QueryRequest request;
//   request.text = "red apple";
//   FREEGS_ASSIGN_OR_RETURN(const nlohmann::json answer,
//                           session.Ask(request, pool));
//
// One thread at a time may ask.
class QuerySession {
 public:
  explicit QuerySession(std::filesystem::path workspace)
      : workspace_(std::move(workspace)) {}

  // Returns what `query --json` prints. The workspace is read again when a
  // stage has replaced the files. request.workspace is not looked at,
  // request.out and request.cameras must be empty. The errors are those of
  // LoadQueryScene and FindAnswer.
  StatusOr<nlohmann::json> Ask(QueryRequest request, ThreadPool& pool);

 private:
  const std::filesystem::path workspace_;
  std::string stamp_;  // Stamp of what is below; empty: it may be incomplete.
  QueryScene scene_;
  QueryNetworks networks_;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_QUERY_QUERY_SESSION_H_
