// SPDX-License-Identifier: BSD-3-Clause
// Answers the requests of the web server: files, status, questions, the scene.
// docs/view.md lists them.

#ifndef FREEGS_STAGES_VIEW_VIEW_API_H_
#define FREEGS_STAGES_VIEW_VIEW_API_H_

#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "core/status.h"
#include "stages/query/query_request.h"
#include "stages/view/access.h"
#include "stages/view/http_message.h"
#include "stages/view/live_queries.h"
#include "stages/view/rate_limit.h"
#include "stages/view/request_target.h"
#include "stages/view/scene_cache.h"
#include "stages/view/turns.h"
#include "stages/view/view_server.h"

namespace freegs::stages {

struct ViewApiOptions {
  std::filesystem::path workspace;

  // The folder of the page's own files (FindWebBundle); empty: there is none.
  std::filesystem::path web = {};

  // Makes the scene for the 3D viewer; may be empty.
  MakeSceneFn make_scene = {};

  // The options of questions that a page does not give, and the threads.
  QueryRequest query_defaults = {};

  // The limit for all pages together.
  double queries_per_second = 20;

  // So many threads of the server may be busy with questions, and as many with
  // instances. One of them works and the others wait for it. One more thread
  // may make the scene (SceneCache). Together they must not be all that there
  // are (ViewServerOptions), or else nothing else is answered.
  int max_at_once = 3;
};

// The answer to a request that may name a scene by its stamp, "?scene=STAMP".
// It is 409 when the workspace has another one, be it before `answer` or after
// it: while a question waits for its turn, the scene may be replaced.
HttpResponse AnswerAboutScene(const std::filesystem::path& workspace,
                              const RequestTarget& target,
                              const std::function<HttpResponse()>& answer);

class ViewApi : public HttpHandler {
 public:
  ViewApi(const ViewApiOptions& options, AccessRules rules);

  std::optional<HttpResponse> Refuse(const HttpRequest& request) override;
  HttpResponse Answer(const HttpRequest& request) override;

 private:
  HttpResponse Route(const HttpRequest& request, const RequestTarget& target);
  HttpResponse FrontPage(const RequestTarget& target) const;
  HttpResponse StatusPage() const;
  HttpResponse Api(std::string_view name, const RequestTarget& target);
  HttpResponse Photo(const std::string& name);
  HttpResponse InstancePly(std::string_view name);
  HttpResponse ScenePart(std::string_view name, const RequestTarget& target);

  // Whether undistort/ has a view of this name.
  StatusOr<bool> IsView(const std::string& name);

  const ViewApiOptions options_;
  const AccessRules rules_;
  LiveQueries queries_;
  SceneCache scene_;
  RateLimit rate_;

  Turns instance_turns_;  // One model is read at a time.

  std::mutex views_mutex_;
  std::string views_stamp_;  // The stamp of the names below.
  std::set<std::string> views_;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_VIEW_API_H_
