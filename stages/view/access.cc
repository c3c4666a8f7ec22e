// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/access.h"

#include <algorithm>
#include <arpa/inet.h>
#include <array>
#include <cstdint>
#include <cstring>
#include <ifaddrs.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/random.h>
#include <unistd.h>
#include <utility>

#include "core/text.h"

namespace freegs::stages {
namespace {

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

bool IsAnyAddress(const std::string& address) {
  return address == "0.0.0.0" || address == "::";
}

// The name of a Host header without its port, which is another one behind a
// tunnel.
std::string HostWithoutPort(const std::string& host) {
  const size_t colon = host.find_last_not_of("0123456789");
  return colon != std::string::npos && host[colon] == ':'
             ? host.substr(0, colon)
             : host;
}

// Whether both are the same IPv6 address. Browsers write it in its shortest
// form, whatever they were given.
bool IsSameIpv6(const std::string& a, const std::string& b) {
  in6_addr first;
  in6_addr second;
  return inet_pton(AF_INET6, a.c_str(), &first) == 1 &&
         inet_pton(AF_INET6, b.c_str(), &second) == 1 &&
         std::memcmp(&first, &second, sizeof(first)) == 0;
}

bool IsOwnHost(const AccessRules& rules, const std::string& header) {
  const std::string name = HostWithoutPort(AsciiLower(header));
  if (name.empty()) return false;
  if (name == "127.0.0.1" || name == "localhost" || name == "[::1]") {
    return true;
  }
  const std::string bracketed = name.starts_with('[') && name.ends_with(']')
                                    ? name.substr(1, name.size() - 2)
                                    : "";
  // An address is never somebody else's name for this machine.
  if (IsAnyAddress(rules.address)) {
    return name == AsciiLower(rules.host_name) || IsIpv4(name) ||
           IsIpv6(bracketed);
  }
  return name == AsciiLower(Bracketed(rules.address)) ||
         IsSameIpv6(bracketed, rules.address);
}

std::vector<std::string> Ipv4Addresses() {
  std::vector<std::string> addresses;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return addresses;
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    char text[NI_MAXHOST];
    if (entry->ifa_addr != nullptr && entry->ifa_addr->sa_family == AF_INET &&
        getnameinfo(entry->ifa_addr,
                    sizeof(sockaddr_in),
                    text,
                    sizeof(text),
                    nullptr,
                    0,
                    NI_NUMERICHOST) == 0) {
      addresses.emplace_back(text);
    }
  }
  freeifaddrs(list);
  return addresses;
}

// Browsers keep cookies by name and host, not by port: two servers on one
// machine need two names.
std::string CookieName(const AccessRules& rules) {
  return "freegs_view_" + std::to_string(rules.port);
}

bool IsJson(const std::string& content_type) {
  const std::string type =
      AsciiLower(content_type.substr(0, content_type.find(';')));
  return type.substr(0, type.find_last_not_of(" \t") + 1) == "application/json";
}

// What getaddrinfo makes of a host, as a number: the first address without an
// interface, or else the first one; empty if it knows none.
std::string Resolved(const std::string& host, int flags) {
  addrinfo hints = {};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = flags;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0) return "";
  std::string best;
  for (const addrinfo* entry = found; entry != nullptr;
       entry = entry->ai_next) {
    char text[NI_MAXHOST] = {};
    if (getnameinfo(entry->ai_addr,
                    entry->ai_addrlen,
                    text,
                    sizeof(text),
                    nullptr,
                    0,
                    NI_NUMERICHOST) != 0) {
      continue;
    }
    const std::string address = text;
    if (best.empty()) best = address;
    if (address.find('%') == std::string::npos) {
      best = address;
      break;
    }
  }
  freeaddrinfo(found);
  return best;
}

}  // namespace

StatusOr<std::string> NumericAddress(const std::string& host) {
  const std::string address = Resolved(host, AI_PASSIVE);
  if (address.empty()) {
    return InvalidArgumentError(host +
                                ": neither an address nor the name of one");
  }
  if (address.find('%') != std::string::npos) {
    return InvalidArgumentError(
        host +
        ": browsers cannot name an address with an interface; give "
        "another one, or :: for all");
  }
  return address;
}

bool IsNumericAddress(const std::string& host) {
  return !Resolved(host, AI_NUMERICHOST).empty();
}

bool IsLoopback(const std::string& address) {
  return address == "localhost" || address == "::1" ||
         (IsIpv4(address) && address.starts_with("127."));
}

std::vector<std::string> ViewAddresses(const AccessRules& rules) {
  std::vector<std::string> hosts;
  if (IsAnyAddress(rules.address)) hosts = Ipv4Addresses();
  if (hosts.empty()) hosts = {Bracketed(rules.address)};
  std::vector<std::string> addresses;
  for (const std::string& host : hosts) {
    std::string address =
        "http://" + host + ":" + std::to_string(rules.port) + "/";
    if (!rules.token.empty()) address += "?token=" + rules.token;
    addresses.push_back(std::move(address));
  }
  return addresses;
}

std::string HostName() {
  std::array<char, 256> name = {};
  // The last byte stays zero, also where a name is cut off.
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
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
      AsciiLower(request.origin) != "http://" + AsciiLower(request.host)) {
    return {403, "pages of other servers may not ask"};
  }
  if (!IsJson(request.content_type)) {
    return {415, "send the question with Content-Type: application/json"};
  }
  return decision;
}

}  // namespace freegs::stages
