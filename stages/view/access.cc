// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/access.h"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <cctype>
#include <cstdint>
#include <sys/random.h>
#include <vector>

namespace freegs::stages {
namespace {

std::string LowerCase(std::string_view text) {
  std::string lower(text);
  std::transform(
      lower.begin(), lower.end(), lower.begin(), [](unsigned char c) {
        return std::tolower(c);
      });
  return lower;
}

bool IsIpv4(const std::string& text) {
  in_addr address = {};
  return inet_pton(AF_INET, text.c_str(), &address) == 1;
}

bool IsIpv6(const std::string& text) {
  in6_addr address = {};
  return inet_pton(AF_INET6, text.c_str(), &address) == 1;
}

// "[::1]" for "::1": with a port behind it, an IPv6 address has brackets.
std::string Bracketed(const std::string& address) {
  return IsIpv6(address) ? "[" + address + "]" : address;
}

// The name of a Host header without its port; empty when the port is another.
std::string HostWithoutPort(const std::string& host, int port) {
  const std::string suffix = ":" + std::to_string(port);
  if (host.ends_with(suffix)) {
    return host.substr(0, host.size() - suffix.size());
  }
  // Browsers leave out the usual port.
  const bool has_port =
      host.find_last_of(':') != std::string::npos && !host.ends_with(']');
  return port == 80 && !has_port ? host : "";
}

bool IsOwnHost(const AccessRules& rules, const std::string& header) {
  const std::string name = HostWithoutPort(LowerCase(header), rules.port);
  if (name.empty()) return false;
  if (name == "127.0.0.1" || name == "localhost" || name == "[::1]") {
    return true;
  }
  // An address is never somebody else's name for this machine.
  if (rules.address == "0.0.0.0" || rules.address == "::") {
    return IsIpv4(name) || (name.starts_with('[') && name.ends_with(']') &&
                            IsIpv6(name.substr(1, name.size() - 2)));
  }
  return name == LowerCase(Bracketed(rules.address));
}

// Browsers keep cookies by name and host, not by port: two servers on one
// machine need two names.
std::string CookieName(const AccessRules& rules) {
  return "freegs_view_" + std::to_string(rules.port);
}

bool IsJson(const std::string& content_type) {
  const std::string type =
      LowerCase(content_type.substr(0, content_type.find(';')));
  return type.substr(0, type.find_last_not_of(" \t") + 1) == "application/json";
}

}  // namespace

bool IsLoopback(const std::string& address) {
  return address == "localhost" || address == "::1" ||
         (IsIpv4(address) && address.starts_with("127."));
}

std::string ViewAddress(const AccessRules& rules) {
  std::string address = "http://" + Bracketed(rules.address) + ":" +
                        std::to_string(rules.port) + "/";
  if (!rules.token.empty()) address += "?token=" + rules.token;
  return address;
}

StatusOr<std::string> MakeToken() {
  std::array<uint8_t, 16> bytes = {};
  if (getrandom(bytes.data(), bytes.size(), 0) !=
      static_cast<ssize_t>(bytes.size())) {
    return InternalError("the system gives no random numbers");
  }
  constexpr char kHex[] = "0123456789abcdef";
  std::string token;
  for (const uint8_t byte : bytes) token += {kHex[byte >> 4], kHex[byte & 15]};
  return token;
}

bool SameText(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  uint8_t difference = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    difference |= static_cast<uint8_t>(a[i] ^ b[i]);
  }
  return difference == 0;
}

std::string_view CookieValue(std::string_view header, std::string_view name) {
  while (!header.empty()) {
    const size_t end = std::min(header.find(';'), header.size());
    std::string_view cookie = header.substr(0, end);
    header.remove_prefix(std::min(end + 1, header.size()));
    const size_t start =
        std::min(cookie.find_first_not_of(" \t"), cookie.size());
    cookie.remove_prefix(start);
    if (cookie.size() > name.size() && cookie.starts_with(name) &&
        cookie[name.size()] == '=') {
      return cookie.substr(name.size() + 1);
    }
  }
  return {};
}

AccessDecision CheckAccess(const AccessRules& rules,
                           const HttpRequest& request,
                           const RequestTarget& target) {
  if (!IsOwnHost(rules, request.host)) {
    return {403,
            "this server is not \"" + request.host.substr(0, 100) +
                "\"; use the address that freegs_pipeline view printed"};
  }
  AccessDecision decision;
  if (!rules.token.empty()) {
    const auto given = target.parameters.find("token");
    if (given != target.parameters.end() &&
        SameText(given->second, rules.token)) {
      decision.set_cookie = CookieName(rules) + "=" + rules.token +
                            "; Path=/; HttpOnly; SameSite=Strict";
    } else if (!SameText(CookieValue(request.cookie, CookieName(rules)),
                         rules.token)) {
      return {403,
              "the token is missing or wrong; open the whole address that "
              "freegs_pipeline view printed"};
    }
  }
  if (request.method != "POST") return decision;
  if (!request.origin.empty() &&
      LowerCase(request.origin) != "http://" + LowerCase(request.host)) {
    return {403, "pages of other servers may not ask"};
  }
  if (!IsJson(request.content_type)) {
    return {415, "send the question with Content-Type: application/json"};
  }
  return decision;
}

}  // namespace freegs::stages
