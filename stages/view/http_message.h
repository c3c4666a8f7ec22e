// SPDX-License-Identifier: BSD-3-Clause
// What a browser asks and what it gets, without the library that carries it
// (view_server.cc alone knows that one).

#ifndef FREEGS_STAGES_VIEW_HTTP_MESSAGE_H_
#define FREEGS_STAGES_VIEW_HTTP_MESSAGE_H_

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "stages/view/open_file.h"

namespace freegs::stages {

// The parts of a request that anything depends on. A header that is missing is
// an empty text.
struct HttpRequest {
  std::string method;  // "GET"
  std::string target;  // As on the request line: "/api/photos/a%20b.jpg?v=1"
  std::string host;
  std::string origin;
  std::string content_type;
  std::string cookie;
  std::string body;
};

// The content is one of `body`, `shared` and `file`.
struct HttpResponse {
  int status = 200;
  std::string content_type = "text/plain; charset=utf-8";
  std::vector<std::pair<std::string, std::string>> headers = {};
  std::string body = {};
  // A large content that several answers share.
  std::shared_ptr<const std::string> shared = nullptr;
  // A file that is read while it is sent.
  std::shared_ptr<const OpenFile> file = nullptr;
};

// {"error": TEXT} with this status. The text names what is wrong and what to
// do.
HttpResponse ErrorResponse(int status, const std::string& text);

// An ErrorResponse with status 429, for who may ask again a second later.
HttpResponse BusyResponse(const std::string& text);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_HTTP_MESSAGE_H_
