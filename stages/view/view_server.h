// SPDX-License-Identifier: BSD-3-Clause
// The web server: sockets, HTTP and its limits. What is answered is the work of
// its handler.

#ifndef FREEGS_STAGES_VIEW_VIEW_SERVER_H_
#define FREEGS_STAGES_VIEW_VIEW_SERVER_H_

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "core/status.h"
#include "stages/view/http_message.h"

namespace freegs::stages {

// Several threads call it at a time.
class HttpHandler {
 public:
  virtual ~HttpHandler() = default;

  // Whether the request is refused. It is called before the body is read, so
  // request.body is empty.
  virtual std::optional<HttpResponse> Refuse(const HttpRequest& request) = 0;

  // The answer to a request that was not refused.
  virtual HttpResponse Answer(const HttpRequest& request) = 0;
};

struct ViewServerOptions {
  std::string address = "127.0.0.1";

  // The first port to try; 0 takes any free one. When it is taken, the next
  // ones are tried, `more_ports` of them.
  int port = 8717;
  int more_ports = 100;

  // Connections that are served at a time. Others wait, up to max_waiting of
  // them; what comes then is closed.
  int max_connections = 8;
  int max_waiting = 64;

  // Bytes of all headers, and of a body; larger ones are refused.
  size_t max_header_bytes = 32 << 10;
  size_t max_body_bytes = 8 << 20;

  // Seconds that a client may take to send its headers, its body, and to take
  // the next part of the answer.
  double header_seconds = 5;
  double body_seconds = 20;
  double write_seconds = 10;
};

//   FREEGS_ASSIGN_OR_RETURN(const auto server, ViewServer::Bind(options));
//   MyHandler handler(server->port());
//   server->Start(&handler);
//   ...
//   server->Stop();
//
// A connection carries one request. So a client that keeps silent holds no
// place for long, and what is left of a body that was refused cannot be taken
// for a request.
class ViewServer {
 public:
  virtual ~ViewServer() = default;

  // Takes a port. kBadInput when the address or all its ports cannot be used.
  static StatusOr<std::unique_ptr<ViewServer>> Bind(
      const ViewServerOptions& options);

  // The port it has.
  virtual int port() const = 0;

  // Serves in threads of its own until Stop. `handler` must outlive that.
  virtual void Start(HttpHandler* handler) = 0;

  // False after Stop, and when the system takes no more connections for it.
  virtual bool running() const = 0;

  // Closes all connections and returns when no handler is at work any more.
  // Nothing happens when it has not started or is stopped.
  virtual void Stop() = 0;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_VIEW_SERVER_H_
