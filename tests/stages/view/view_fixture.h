// SPDX-License-Identifier: BSD-3-Clause
// A small workspace that is served, and a client that sends any bytes.

#ifndef FREEGS_TESTS_STAGES_VIEW_VIEW_FIXTURE_H_
#define FREEGS_TESTS_STAGES_VIEW_VIEW_FIXTURE_H_

#include <arpa/inet.h>
#include <memory>
#include <string>
#include <string_view>
#include <sys/socket.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "stages/view/view_api.h"
#include "stages/view/view_server.h"
#include "tests/stages/synthetic_workspace.h"
#include "tests/stages/word_features.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {

// A connection to a port of this machine. The server's answer must come within
// ten seconds.
class RawClient {
 public:
  explicit RawClient(int port) {
    socket_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval patience = {10, 0};
    setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    connected_ = connect(socket_,
                         reinterpret_cast<const sockaddr*>(&address),
                         sizeof(address)) == 0;
  }
  ~RawClient() { close(socket_); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  bool connected() const { return connected_; }

  void Send(std::string_view bytes) const {
    while (!bytes.empty()) {
      const ssize_t sent =
          send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return;
      bytes.remove_prefix(static_cast<size_t>(sent));
    }
  }

  // Everything up to the end of the connection.
  std::string Receive() const {
    std::string text;
    char bytes[4096];
    for (;;) {
      const ssize_t received = recv(socket_, bytes, sizeof(bytes), 0);
      if (received <= 0) return text;
      text.append(bytes, static_cast<size_t>(received));
    }
  }

 private:
  int socket_ = -1;
  bool connected_ = false;
};

class ViewTest : public testing::Test {
 protected:
  ViewTest() {
    workspace_.AddInstances();
    workspace_.AddHierarchy();
    WriteWordFeatures(workspace_ / "bootstrap/instance_features.json");
    WriteText(workspace_ / "export/report/index.html", "<p>The report</p>");
    WriteText(workspace_ / "export/scene.ply", "ply");
    options_.workspace = workspace_.path();
    options_.queries_per_second = 1000;
    server_options_.port = 0;
  }
  ~ViewTest() override { Stop(); }

  void Start(const std::string& token = "") {
    auto server = ViewServer::Bind(server_options_);
    ASSERT_TRUE(server.ok()) << server.status().message();
    server_ = *std::move(server);
    AccessRules rules = {
        .address = "127.0.0.1", .port = server_->port(), .token = token};
    api_ = std::make_unique<ViewApi>(options_, rules);
    server_->Start(api_.get());
  }

  void Stop() {
    if (server_) server_->Stop();
  }

  int port() const { return server_->port(); }
  std::string host() const { return "127.0.0.1:" + std::to_string(port()); }

  // The answer to a request line and headers; a Host is added.
  std::string Raw(const std::string& line,
                  const std::string& headers = "",
                  const std::string& body = "") const {
    const RawClient client(port());
    client.Send(line + " HTTP/1.1\r\nHost: " + host() + "\r\n" + headers +
                "\r\n" + body);
    return client.Receive();
  }
  static int StatusOf(const std::string& answer) {
    return answer.size() < 12 ? 0 : std::atoi(answer.c_str() + 9);
  }

  SyntheticWorkspace workspace_;
  ViewApiOptions options_;
  ViewServerOptions server_options_;
  std::unique_ptr<ViewApi> api_;
  std::unique_ptr<ViewServer> server_;
};

}  // namespace freegs::stages

#endif  // FREEGS_TESTS_STAGES_VIEW_VIEW_FIXTURE_H_
