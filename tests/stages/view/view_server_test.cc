// SPDX-License-Identifier: BSD-3-Clause
// The limits of the server, with clients that keep to no rule.

#include "stages/view/view_server.h"

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/stages/view/view_fixture.h"

namespace freegs::stages {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

constexpr char kServerToken[] = "0123456789abcdef0123456789abcdef";
constexpr char kJson[] = "Content-Type: application/json\r\n";

double SecondsSince(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin)
      .count();
}

class ViewServerTest : public ViewTest {
 protected:
  std::string Ask(const std::string& body,
                  const std::string& headers = kJson) const {
    return Raw(
        "POST /api/query",
        headers + "Content-Length: " + std::to_string(body.size()) + "\r\n",
        body);
  }
};

TEST_F(ViewServerTest, EveryAnswerHasTheSafetyHeaders) {
  Start();
  for (const char* line : {"GET /report/",
                           "GET /nothing",
                           "PUT /",
                           "GET /api/status",
                           "nonsense"}) {
    EXPECT_THAT(Raw(line),
                AllOf(HasSubstr("Content-Security-Policy: default-src 'self'; "
                                "script-src 'self' 'unsafe-inline'"),
                      HasSubstr("X-Content-Type-Options: nosniff"),
                      HasSubstr("Referrer-Policy: no-referrer"),
                      HasSubstr("Cross-Origin-Resource-Policy: same-origin"),
                      HasSubstr("Cache-Control: no-cache"),
                      HasSubstr("Connection: close"),
                      Not(HasSubstr("Access-Control"))))
        << line;
  }
}

TEST_F(ViewServerTest, ServesNothingOutsideOfExport) {
  fs::create_symlink(workspace_ / "ingest/images.json",
                     workspace_ / "export/link.json");
  fs::create_directory_symlink(workspace_.path(), workspace_ / "export/up");
  fs::create_directory_symlink(workspace_ / "ingest",
                               workspace_ / "export/report/ingest");
  Start();
  for (const char* target : {"/../ingest/images.json",
                             "/report/../../ingest/images.json",
                             "/%2e%2e/ingest/images.json",
                             "/%2E%2E%2Fingest/images.json",
                             "/..%2fingest%2fimages.json",
                             "/..%5cingest%5cimages.json",
                             "/..\\ingest\\images.json",
                             "/link.json",
                             "/up/ingest/images.json",
                             "/report/ingest/images.json",
                             "/scene.ply%00.html",
                             "//etc/passwd",
                             "/%2fetc/passwd",
                             "/report",
                             "/masks/",
                             "/web/../scene.ply",
                             "/web/live.html",
                             "/api/photos/../stage.json",
                             "/api/photos/..%2f..%2fingest%2fimages.json",
                             "http://127.0.0.1/report/"}) {
    EXPECT_EQ(StatusOf(Raw(std::string("GET ") + target)), 404) << target;
  }
  EXPECT_EQ(StatusOf(Raw("GET /scene.ply")), 200);
}

TEST_F(ViewServerTest, TheExportFolderItselfMayBeALink) {
  fs::rename(workspace_ / "export", workspace_ / "elsewhere");
  fs::create_directory_symlink("elsewhere", workspace_ / "export");
  Start();
  EXPECT_THAT(Raw("GET /report/"), HasSubstr("The report"));
}

TEST_F(ViewServerTest, OtherNamesOfThisMachineAreRefused) {
  Start();
  const auto with_host = [this](const std::string& hosts) {
    const RawClient client(port());
    client.Send("GET /api/status HTTP/1.1\r\n" + hosts + "\r\n");
    return client.Receive();
  };
  const std::string port_text = std::to_string(port());
  EXPECT_EQ(StatusOf(with_host("Host: localhost:" + port_text + "\r\n")), 200);
  EXPECT_THAT(with_host("Host: evil.example:" + port_text + "\r\n"),
              AllOf(HasSubstr("403"), HasSubstr("freegs_pipeline view")));
  EXPECT_EQ(StatusOf(with_host("")), 403);
  EXPECT_EQ(StatusOf(with_host("Host: localhost:" + port_text +
                               "\r\nHost: evil.example\r\n")),
            400);
}

TEST_F(ViewServerTest, OnlyGetAndTheQuestionAreAllowed) {
  Start();
  for (const char* method : {"PUT", "DELETE", "PATCH", "OPTIONS", "TRACE"}) {
    EXPECT_EQ(StatusOf(Raw(std::string(method) + " /report/")), 405) << method;
  }
  EXPECT_EQ(
      StatusOf(Raw(
          "POST /report/", std::string(kJson) + "Content-Length: 2\r\n", "{}")),
      405);
  EXPECT_THAT(Raw("GET /api/query"),
              AllOf(HasSubstr("405"), HasSubstr("Allow: POST")));
  const std::string head = Raw("HEAD /report/");
  EXPECT_EQ(StatusOf(head), 200);
  EXPECT_THAT(
      head,
      AllOf(HasSubstr("Content-Length: 17"), Not(HasSubstr("The report"))));
}

TEST_F(ViewServerTest, QuestionsOfOtherPagesAreRefused) {
  Start();
  const std::string question = R"({"text": "red apple"})";
  EXPECT_EQ(StatusOf(Ask(question)), 200);
  EXPECT_EQ(
      StatusOf(Ask(question,
                   std::string(kJson) + "Origin: http://" + host() + "\r\n")),
      200);
  EXPECT_EQ(
      StatusOf(Ask(question, std::string(kJson) + "Origin: http://evil\r\n")),
      403);
  EXPECT_EQ(StatusOf(Ask(question, "Content-Type: text/plain\r\n")), 415);
  EXPECT_EQ(StatusOf(Ask(question, "")), 415);
}

TEST_F(ViewServerTest, LargeRequestsAreRefused) {
  server_options_.max_body_bytes = 1 << 20;
  Start();
  EXPECT_THAT(Ask(std::string(2 << 20, ' ')),
              AllOf(HasSubstr("413"), HasSubstr("larger than 1 MB")));
  // Full size, and no JSON.
  EXPECT_EQ(StatusOf(Ask(std::string(1 << 20, ' '))), 400);
  EXPECT_EQ(StatusOf(Raw("POST /api/query",
                         std::string(kJson) + "Transfer-Encoding: chunked\r\n",
                         "2\r\n{}\r\n0\r\n\r\n")),
            411);
  EXPECT_EQ(StatusOf(Raw("POST /api/query", kJson)), 411);
  EXPECT_EQ(StatusOf(Raw("POST /api/query",
                         std::string(kJson) +
                             "Content-Length: 99999999999999999999\r\n")),
            413);
  EXPECT_EQ(StatusOf(Raw("POST /api/query",
                         std::string(kJson) + "Content-Length: -1\r\n")),
            411);
  EXPECT_EQ(StatusOf(Raw("POST /api/query",
                         std::string(kJson) +
                             "Content-Length: 2\r\nContent-Length: 3\r\n",
                         "{}")),
            400);
  // Many headers, and one that is long.
  std::string headers;
  for (int i = 0; i < 4000; ++i) headers += "X-A: 0123456789\r\n";
  EXPECT_NE(StatusOf(Raw("GET /api/status", headers)), 200);
  EXPECT_NE(StatusOf(Raw("GET /" + std::string(20000, 'a'))), 200);
  // What the library refuses says so, too.
  for (const std::string& answer :
       {Raw("GET /api/status", "Cookie: a=" + std::string(9000, 'a') + "\r\n"),
        Raw("GET /" + std::string(9000, 'a')),
        Raw("FOO /api/status"),
        Raw("GET /api/status", "Range: items=0-5\r\n")}) {
    EXPECT_GE(StatusOf(answer), 400);
    EXPECT_THAT(answer, HasSubstr("{\"error\":")) << answer;
  }
  EXPECT_EQ(StatusOf(Raw("GET /api/status")), 200);
}

TEST_F(ViewServerTest, ClientsThatKeepSilentHoldNoPlace) {
  server_options_.header_seconds = 0.3;
  server_options_.max_connections = 2;
  Start();
  const RawClient silent(port());
  const RawClient slow(port());
  slow.Send("GET / HT");
  const RawClient third(port());
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(StatusOf(Raw("GET /api/status")), 200);
  EXPECT_LT(SecondsSince(begin), 5);
}

TEST_F(ViewServerTest, ConnectionsBeyondTheQueueAreClosed) {
  server_options_.max_connections = 1;
  server_options_.max_waiting = 1;
  server_options_.header_seconds = 1;
  Start();
  // One is served, one waits, and of the others some find the queue full.
  const auto settle = [] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  };
  const RawClient served(port());
  settle();
  const RawClient waiting(port());
  settle();
  const RawClient more(port());
  const RawClient most(port());
  most.Send("GET /api/status HTTP/1.1\r\nHost: " + host() + "\r\n\r\n");
  EXPECT_EQ(most.Receive(), "");
  // When the silent ones have gone, there is place again.
  EXPECT_EQ(served.Receive() + waiting.Receive() + more.Receive(), "");
  EXPECT_EQ(StatusOf(Raw("GET /api/status")), 200);
}

TEST_F(ViewServerTest, StopsWithinASecond) {
  Start();
  const RawClient silent(port());
  const RawClient slow(port());
  slow.Send("POST /api/query HTTP/1.1\r\nHost: " + host() + "\r\n" + kJson +
            "Content-Length: 100\r\n\r\n{");
  EXPECT_EQ(StatusOf(Raw("GET /api/status")), 200);
  const auto begin = std::chrono::steady_clock::now();
  Stop();
  EXPECT_LT(SecondsSince(begin), 1);
  EXPECT_FALSE(RawClient(port()).connected());
}

TEST_F(ViewServerTest, SeveralClientsAtOnce) {
  WriteText(workspace_ / "export/large.bin", std::string(5 << 20, 'x'));
  options_.max_at_once = 6;
  Start();
  std::vector<std::thread> clients;
  std::vector<int> good(6);
  for (size_t i = 0; i < good.size(); ++i) {
    clients.emplace_back([this, i, &good] {
      for (int k = 0; k < 5; ++k) {
        const bool large = (i + k) % 2 == 0;
        const std::string answer =
            large ? Raw("GET /large.bin") : Ask(R"({"text": "red apple"})");
        good[i] +=
            StatusOf(answer) == 200 && (!large || answer.size() > (5 << 20));
      }
    });
  }
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(good, std::vector<int>(good.size(), 5));
}

TEST_F(ViewServerTest, TooManyQuestionsAreRefused) {
  options_.queries_per_second = 3;
  Start();
  int refused = 0;
  for (int i = 0; i < 8; ++i) {
    const std::string answer = Ask("{}");
    if (StatusOf(answer) != 429) continue;
    ++refused;
    EXPECT_THAT(answer, HasSubstr("Retry-After: 1"));
  }
  EXPECT_GE(refused, 1);
  EXPECT_LE(refused, 5);
}

TEST_F(ViewServerTest, WithATokenNobodyElseSeesAnything) {
  Start(kServerToken);
  EXPECT_EQ(StatusOf(Raw("GET /report/")), 403);
  EXPECT_EQ(StatusOf(Raw("GET /report/?token=00000000")), 403);
  EXPECT_EQ(StatusOf(Ask(R"({"text": "red apple"})")), 403);
  const std::string first = Raw(std::string("GET /?token=") + kServerToken);
  const std::string name = "freegs_view_" + std::to_string(port());
  EXPECT_THAT(
      first,
      AllOf(HasSubstr("302"),
            HasSubstr(std::string("Location: /report/?token=") + kServerToken),
            HasSubstr("Set-Cookie: " + name + "=" + kServerToken +
                      "; Path=/; HttpOnly; SameSite=Strict")));
  const std::string cookie = "Cookie: " + name + "=" + kServerToken + "\r\n";
  EXPECT_EQ(StatusOf(Raw("GET /report/", cookie)), 200);
  EXPECT_EQ(StatusOf(Ask(R"({"text": "red apple"})", kJson + cookie)), 200);
  EXPECT_EQ(StatusOf(Raw("GET /report/", "Cookie: " + name + "=wrong\r\n")),
            403);
}

TEST_F(ViewServerTest, APortIsNotShared) {
  Start();
  server_options_.port = port();
  server_options_.more_ports = 0;
  const auto second = ViewServer::Bind(server_options_);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(second.status().message(), HasSubstr("--port"));
  server_options_.more_ports = 50;
  const auto next = ViewServer::Bind(server_options_);
  ASSERT_TRUE(next.ok()) << next.status().message();
  EXPECT_GT((*next)->port(), port());
}

}  // namespace
}  // namespace freegs::stages
