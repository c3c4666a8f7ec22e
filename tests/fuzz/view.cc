// SPDX-License-Identifier: BSD-3-Clause
// What browsers, and others, send to the server of `view`.

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "stages/view/access.h"
#include "stages/view/open_file.h"
#include "stages/view/query_body.h"
#include "stages/view/request_target.h"
#include "tests/fuzz/reader.h"

namespace freegs::fuzz {
namespace {

namespace fs = std::filesystem;

// A folder to serve, beside a file that nobody may get.
const fs::path& ServedFolder() {
  static const fs::path folder = [] {
    const fs::path root = Scratch() / "served";
    WriteText(root / "report/index.html", "served");
    WriteText(root / "a b.txt", "served");
    WriteText(Scratch() / "secret.txt", "secret");
    std::error_code ignored;
    fs::create_symlink(Scratch() / "secret.txt", root / "link.txt", ignored);
    fs::create_directory_symlink("..", root / "up", ignored);
    return root;
  }();
  return folder;
}

// Takes the text up to a line break off the front.
std::string TakeLine(std::string_view* bytes) {
  const size_t end = std::min(bytes->find('\n'), bytes->size());
  const std::string line(bytes->substr(0, end));
  bytes->remove_prefix(std::min(end + 1, bytes->size()));
  return line;
}

}  // namespace

// A path that is served lies below the folder, whatever it is made of.
Reader RequestPath() {
  return {[](std::string_view bytes) {
            const auto target = stages::ParseRequestTarget(bytes);
            const std::string name =
                target ? target->path.substr(1) : std::string(bytes);
            Require(!target || target->path.starts_with('/'));
            Require(!target ||
                    ("/" + name + "/").find("/../") == std::string::npos);
            const auto file = stages::OpenBelow(ServedFolder(), name);
            if (file.ok()) {
              char content[6] = {};
              (*file)->Read(0, content, sizeof(content));
              Require(std::string(content, 6) == "served");
            }
            (void)stages::ContentType(name);
          },
          [] {
            return std::vector<std::string>{"/report/index.html?v=1&w",
                                            "/a%20b.txt",
                                            "/link.txt",
                                            "/up/secret.txt",
                                            "/%2e%2e/secret.txt",
                                            "../secret.txt",
                                            "/report/..%2f..\\secret.txt"};
          }};
}

Reader QuestionBody() {
  return {
      [](std::string_view bytes) {
        auto question = stages::ParseQueryBody(bytes, {});
        if (!question.ok()) {
          Require(!question.status().message().empty());
          return;
        }
        const bool decoded = stages::DecodePicture(&*question).ok();
        const auto* const request = &question->request;
        Require(request->text.has_value() + request->example.has_value() +
                    request->click.has_value() ==
                1);
        Require(request->max_hits >= 0 && request->out.empty());
        Require(!decoded || !request->example ||
                !request->example_pixels.empty());
      },
      [] {
        // A grey PNG of one pixel.
        return std::vector<std::string>{
            R"({"text": "red apple", "max_hits": 2, "background": true})",
            R"({"click": {"view": "a.jpg", "x": 4.5, "y": 2, "level": -1}})",
            R"({"example": "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4)"
            R"(nGNoAAAAggCBd81ytgAAAABJRU5ErkJggg=="})"};
      }};
}

// Lines: method, target, Host, Origin, Content-Type, Cookie.
Reader RequestHeaders() {
  return {[](std::string_view bytes) {
            const std::string token = "0123456789abcdef0123456789abcdef";
            stages::HttpRequest request;
            request.method = TakeLine(&bytes);
            request.target = TakeLine(&bytes);
            request.host = TakeLine(&bytes);
            request.origin = TakeLine(&bytes);
            request.content_type = TakeLine(&bytes);
            request.cookie = TakeLine(&bytes);
            const auto target = stages::ParseRequestTarget(request.target);
            if (!target) return;
            const auto allowed = stages::CheckAccess(
                {.address = "192.168.1.5", .port = 8717, .token = token},
                request,
                *target);
            if (allowed.status != 200) {
              Require(!allowed.error.empty());
              return;
            }
            // Only those who know the token come in.
            Require(request.cookie.find(token) != std::string::npos ||
                    target->parameters.at("token") == token);
            // The host is this machine, whatever its port.
            std::string host = request.host;
            for (char& c : host) {
              if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
            }
            Require(host.starts_with("localhost") ||
                    host.starts_with("127.0.0.1") ||
                    host.starts_with("[::1]") ||
                    host.starts_with("192.168.1.5"));
          },
          [] {
            const std::string token = "0123456789abcdef0123456789abcdef";
            return std::vector<std::string>{
                "GET\n/?token=" + token + "\nlocalhost:8717\n\n\n\n",
                "POST\n/api/query\n192.168.1.5:8717\n"
                "http://192.168.1.5:8717\napplication/json; a=b\n"
                "a=1; freegs_view_8717=" +
                    token,
                "GET\n/\n[::1]:8717\nnull\ntext/plain\nfreegs_view_8717=0"};
          }};
}

}  // namespace freegs::fuzz
