// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/view_server.h"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <sys/socket.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

// It takes seconds to compile: no other file of the program includes it.
#include <httplib.h>

#include "stages/view/bounded_queue.h"
#include "stages/view/connection.h"

namespace freegs::stages {
namespace {

constexpr size_t kFileBytes = 64 << 10;  // So much of a file is sent at a time.

// The headers of every answer, also of those that the library makes by itself.
const httplib::Headers& SafetyHeaders() {
  static const httplib::Headers headers = {
      {"Content-Security-Policy",
       "default-src 'self'; script-src 'self' 'unsafe-inline' "
       "'wasm-unsafe-eval' blob:; worker-src blob: 'self'; style-src 'self' "
       "'unsafe-inline'; img-src 'self' data: blob:; connect-src 'self' data: "
       "blob:; frame-ancestors 'self'; base-uri 'self'; form-action 'self'"},
      {"X-Content-Type-Options", "nosniff"},
      {"Referrer-Policy", "no-referrer"},
      {"Cross-Origin-Resource-Policy", "same-origin"},
      {"Cache-Control", "no-cache"},
      {"Accept-Ranges", "none"}};
  return headers;
}

// The queue of connections as the library sees it, which deletes it.
class ConnectionQueue : public httplib::TaskQueue {
 public:
  ConnectionQueue(int num_threads, int max_waiting)
      : queue_(num_threads, max_waiting) {}

  void enqueue(std::function<void()> task) override {
    queue_.Push(std::move(task));
  }
  void shutdown() override { queue_.Finish(); }

 private:
  BoundedQueue queue_;
};

// A connection as the library sees it.
class ConnectionStream : public httplib::Stream {
 public:
  ConnectionStream(int socket, double write_seconds, Connection* connection)
      : socket_(socket),
        write_seconds_(write_seconds),
        connection_(connection) {}

  bool is_readable() const override { return true; }
  bool is_writable() const override { return true; }
  ssize_t read(char* bytes, size_t count) override {
    return connection_->Read(bytes, count);
  }
  ssize_t write(const char* bytes, size_t count) override {
    return connection_->Write(bytes, count, write_seconds_);
  }
  // Nothing depends on who asks.
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return socket_; }

 private:
  const int socket_;
  const double write_seconds_;
  Connection* connection_;
};

HttpRequest FromLibrary(const httplib::Request& request) {
  return {.method = request.method,
          .target = request.target,
          .host = request.get_header_value("Host"),
          .origin = request.get_header_value("Origin"),
          .content_type = request.get_header_value("Content-Type"),
          .cookie = request.get_header_value("Cookie"),
          .body = {}};
}

void SendShared(std::shared_ptr<const std::string> content,
                const std::string& type,
                httplib::Response* answer) {
  const size_t size = content->size();
  answer->set_content_provider(
      size,
      type,
      [content = std::move(content)](
          size_t offset, size_t length, httplib::DataSink& sink) {
        return sink.write(content->data() + offset, length);
      });
}

void SendFile(std::shared_ptr<const OpenFile> file,
              const std::string& type,
              httplib::Response* answer) {
  const uint64_t size = file->size();
  answer->set_content_provider(
      size,
      type,
      [file = std::move(file)](
          size_t offset, size_t length, httplib::DataSink& sink) {
        std::vector<char> bytes(std::min(length, kFileBytes));
        const size_t count = file->Read(offset, bytes.data(), bytes.size());
        // A file that has become shorter ends the connection.
        return count > 0 && sink.write(bytes.data(), count);
      });
}

void ToLibrary(HttpResponse response, httplib::Response* answer) {
  answer->status = response.status;
  for (const auto& [name, value] : response.headers) {
    answer->set_header(name, value);
  }
  if (response.file && response.file->size() > 0) {
    SendFile(std::move(response.file), response.content_type, answer);
  } else if (response.shared && !response.shared->empty()) {
    SendShared(std::move(response.shared), response.content_type, answer);
  } else {
    answer->set_content(response.body, response.content_type);
  }
}

// Headers that one request may have once only: two would be read in two ways.
bool HasDoubleHeader(const httplib::Request& request) {
  for (const char* name : {"Host",
                           "Origin",
                           "Content-Type",
                           "Content-Length",
                           "Transfer-Encoding",
                           "Cookie"}) {
    if (request.get_header_value_count(name) > 1) return true;
  }
  return false;
}

class HttplibServer : public ViewServer, private httplib::Server {
 public:
  explicit HttplibServer(const ViewServerOptions& options) : options_(options) {
    new_task_queue = [this] {
      return new ConnectionQueue(options_.max_connections,
                                 options_.max_waiting);
    };
    set_default_headers(SafetyHeaders());
    // The library would also share the port with another server of this user.
    set_socket_options([](socket_t socket) {
      const int yes = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
    });
    set_pre_routing_handler(
        [this](const httplib::Request& request, httplib::Response& answer) {
          return BeforeBody(request, &answer) ? HandlerResponse::Handled
                                              : HandlerResponse::Unhandled;
        });
    Post(".*",
         [this](const httplib::Request& request,
                httplib::Response& answer,
                const httplib::ContentReader& reader) {
           WithBody(request, reader, &answer);
         });
    // Of what the library refuses by itself.
    set_error_handler([](const httplib::Request&, httplib::Response& answer) {
      if (!answer.body.empty()) return;
      ToLibrary(ErrorResponse(answer.status,
                              "this is no request that the server knows, or a "
                              "line of it is longer than 8 kB"),
                &answer);
    });
    set_exception_handler(
        [](const httplib::Request&, httplib::Response& answer, const auto&) {
          ToLibrary(ErrorResponse(500,
                                  "the server has failed; is there "
                                  "memory left?"),
                    &answer);
        });
  }
  ~HttplibServer() override { Stop(); }

  Status TakePort() {
    for (int i = 0; i <= options_.more_ports; ++i) {
      const int port = options_.port == 0 ? 0 : options_.port + i;
      if (port > 65535) break;
      if (port == 0) {
        port_ = bind_to_any_port(options_.address);
      } else if (bind_to_port(options_.address, port)) {
        port_ = port;
      }
      if (port_ > 0) return Status();
      if (port == 0) break;
    }
    std::string what = options_.address;
    if (options_.port != 0) what += ":" + std::to_string(options_.port);
    return BadInputError(
        what +
        ": cannot listen there; another program has the port, or the "
        "address is not this machine's. Give --port 0 for any free "
        "port, or another --host");
  }

  int port() const override { return port_; }

  void Start(HttpHandler* handler) override {
    handler_ = handler;
    thread_ = std::thread([this] {
      listen_after_bind();
      ended_ = true;
    });
    while (!is_running() && !ended_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  bool running() const override { return is_running() && !ended_; }

  void Stop() override {
    if (!thread_.joinable()) return;
    sockets_.Shutdown();
    stop();
    thread_.join();
  }

 private:
  // True when the request was answered.
  bool BeforeBody(const httplib::Request& request, httplib::Response* answer) {
    if (HasDoubleHeader(request)) {
      ToLibrary(ErrorResponse(400, "a header is given twice"), answer);
      return true;
    }
    const HttpRequest asked = FromLibrary(request);
    std::optional<HttpResponse> refusal = handler_->Refuse(asked);
    if (!refusal && request.method == "POST") {
      const std::string length = request.get_header_value("Content-Length");
      uint64_t bytes = 0;
      const char* end = length.data() + length.size();
      const auto parsed = std::from_chars(length.data(), end, bytes);
      if (request.has_header("Transfer-Encoding") || length.empty() ||
          parsed.ptr != end) {
        refusal = ErrorResponse(411, "send the length of the question");
      } else if (parsed.ec != std::errc() || bytes > options_.max_body_bytes) {
        refusal = TooLarge();
      }
    }
    if (!refusal && request.method == "POST") return false;
    ToLibrary(refusal ? *std::move(refusal) : handler_->Answer(asked), answer);
    return true;
  }

  void WithBody(const httplib::Request& request,
                const httplib::ContentReader& reader,
                httplib::Response* answer) {
    HttpRequest asked = FromLibrary(request);
    const bool complete = reader([&](const char* bytes, size_t count) {
      asked.body.append(bytes, count);
      return asked.body.size() <= options_.max_body_bytes;
    });
    ToLibrary(complete ? handler_->Answer(asked)
                       : ErrorResponse(400, "the question is not complete"),
              answer);
  }

  HttpResponse TooLarge() const {
    return ErrorResponse(413,
                         "the question is larger than " +
                             std::to_string(options_.max_body_bytes >> 20) +
                             " MB; send a smaller picture");
  }

  // In place of the library's own, which waits for silent clients even when it
  // is stopped, and reads headers of any number.
  bool process_and_close_socket(socket_t socket) override {
    if (!BoundedQueue::Overflows() && sockets_.Add(socket)) {
      Connection connection(socket);
      ConnectionStream stream(socket, options_.write_seconds, &connection);
      connection.AllowReading(options_.max_header_bytes,
                              options_.header_seconds);
      bool closed = false;
      process_request(
          stream, /*close_connection=*/true, closed, [&](auto& request) {
            connection.AllowReading(options_.max_body_bytes,
                                    options_.body_seconds);
            // No parts of files, and no packing: that costs more time than a
            // connection within a machine.
            request.ranges.clear();
            request.headers.erase("Accept-Encoding");
            // A packed question would be unpacked to any size.
            request.headers.erase("Content-Encoding");
          });
      connection.Linger();
      sockets_.Remove(socket);
    }
    close(socket);
    return true;
  }

  const ViewServerOptions options_;
  HttpHandler* handler_ = nullptr;
  int port_ = 0;
  OpenSockets sockets_;
  std::thread thread_;
  std::atomic<bool> ended_ = false;  // The thread accepts no more connections.
};

}  // namespace

StatusOr<std::unique_ptr<ViewServer>> ViewServer::Bind(
    const ViewServerOptions& options) {
  auto server = std::make_unique<HttplibServer>(options);
  FREEGS_RETURN_IF_ERROR(server->TakePort());
  return std::unique_ptr<ViewServer>(std::move(server));
}

}  // namespace freegs::stages
