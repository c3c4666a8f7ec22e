// SPDX-License-Identifier: BSD-3-Clause
// Who may ask: only pages of the server itself, and from other machines only
// those who know the token.

#ifndef FREEGS_STAGES_VIEW_ACCESS_H_
#define FREEGS_STAGES_VIEW_ACCESS_H_

#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"
#include "stages/view/http_message.h"
#include "stages/view/request_target.h"

namespace freegs::stages {

struct AccessRules {
  std::string address = "127.0.0.1";  // That the server listens at.
  int port = 0;

  // What everybody must know; empty at a loopback address, where only users of
  // this machine can ask.
  std::string token = {};

  // This machine's name. The server answers to it when it listens at all
  // addresses.
  std::string host_name = {};
};

// The address as a number, in its usual form, of an address or a name. Of a
// name that has several it is the first that a browser can name, so that a
// server does not listen at one and print another's. kInvalidArgument for what
// is neither, and for an address that is complete only with an interface
// ("fe80::1%eth0"), which no browser sends.
StatusOr<std::string> NumericAddress(const std::string& host);

// Whether it is an address and no name, also in a form such as "127.1".
bool IsNumericAddress(const std::string& host);

// Whether the address or name is this machine's own and reaches no network.
bool IsLoopback(const std::string& address);

// "http://127.0.0.1:8717/", with the token where there is one. A server at all
// addresses has one for each IPv4 address of this machine. Never empty.
std::vector<std::string> ViewAddresses(const AccessRules& rules);

// The name of this machine; empty when it is not known.
std::string HostName();

// A new token: 128 random bits as 32 hex digits. kInternal when the system has
// no random numbers.
StatusOr<std::string> MakeToken();

// Compares in a time that tells nothing about where the two differ.
bool SameText(std::string_view a, std::string_view b);

// The value of a cookie in a Cookie header; empty if it is not there.
std::string_view CookieValue(std::string_view header, std::string_view name);

struct AccessDecision {
  int status = 200;  // Other than 200: the request is refused.
  std::string error = {};
  // The token came with the target: the answer shall set this cookie.
  std::string set_cookie = {};
};

// Refuses a request
//  - whose Host is not the server's own, whatever its port: a page of another
//    name whose address was turned to this machine would else read everything
//    (DNS rebinding);
//  - without the token, in the parameter "token" or in the cookie;
//  - by a POST from a page of another origin, or of another content than JSON,
//    which a browser would send without asking first.
AccessDecision CheckAccess(const AccessRules& rules,
                           const HttpRequest& request,
                           const RequestTarget& target);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_ACCESS_H_
