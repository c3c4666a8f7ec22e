// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/access.h"

#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr char kToken[] = "0123456789abcdef0123456789abcdef";

int Decide(const AccessRules& rules,
           const HttpRequest& request,
           const std::string& target = "/") {
  return CheckAccess(rules, request, *ParseRequestTarget(target)).status;
}

HttpRequest From(const std::string& host) {
  HttpRequest request;
  request.method = "GET";
  request.host = host;
  return request;
}

TEST(Access, OnlyTheServersOwnNames) {
  const AccessRules rules = {.address = "127.0.0.1", .port = 8717};
  for (const char* host :
       {"127.0.0.1:8717", "localhost:8717", "LocalHost:8717", "[::1]:8717"}) {
    EXPECT_EQ(Decide(rules, From(host)), 200) << host;
  }
  // A tunnel has a port of its own.
  for (const char* host :
       {"127.0.0.1", "localhost", "[::1]", "127.0.0.1:8718", "localhost:80"}) {
    EXPECT_EQ(Decide(rules, From(host)), 200) << host;
  }
  for (const char* host : {"",
                           "8717",
                           "localhost:8717:8717",
                           "localhost:x",
                           "::1",
                           "machine:8717",
                           "evil.example",
                           "evil.example:8717",
                           "localhost.evil.example:8717",
                           "evil@localhost:8717",
                           "192.168.1.5:8717",
                           ":8717"}) {
    EXPECT_EQ(Decide(rules, From(host)), 403) << host;
  }
}

TEST(Access, AnAddressOfTheNetworkIsAName) {
  const AccessRules one = {.address = "192.168.1.5", .port = 8717};
  EXPECT_EQ(Decide(one, From("192.168.1.5:8717")), 200);
  EXPECT_EQ(Decide(one, From("192.168.1.6:8717")), 403);
  const AccessRules six = {.address = "fe80::1", .port = 8717};
  EXPECT_EQ(Decide(six, From("[fe80::1]:8717")), 200);
  const AccessRules longer = {.address = "fe80:0:0::01", .port = 8717};
  EXPECT_EQ(Decide(longer, From("[fe80::1]:8717")), 200);
  EXPECT_EQ(Decide(longer, From("[fe80::2]:8717")), 403);
  // All addresses: those that are numbers cannot be turned to this machine.
  AccessRules all = {.address = "0.0.0.0", .port = 8717};
  EXPECT_EQ(Decide(all, From("192.168.1.6:8717")), 200);
  EXPECT_EQ(Decide(all, From("[fe80::1]:8717")), 200);
  EXPECT_EQ(Decide(all, From("evil.example:8717")), 403);
  EXPECT_EQ(Decide(all, From("machine:8717")), 403);
  all.host_name = "Machine";
  EXPECT_EQ(Decide(all, From("machine:8717")), 200);
  EXPECT_EQ(Decide(all, From("machine.evil.example:8717")), 403);
  EXPECT_EQ(Decide(all, From("")), 403);
}

TEST(Access, AddressesThatOtherMachinesCanOpen) {
  EXPECT_THAT(ViewAddresses({.address = "::1", .port = 5, .token = "ab"}),
              ElementsAre("http://[::1]:5/?token=ab"));
  EXPECT_THAT(ViewAddresses({.address = "0.0.0.0", .port = 5, .token = "ab"}),
              AllOf(Contains("http://127.0.0.1:5/?token=ab"),
                    Not(Contains(HasSubstr("0.0.0.0:")))));
}

TEST(Access, TheTokenOpensByTargetOrByCookie) {
  const AccessRules rules = {
      .address = "192.168.1.5", .port = 8717, .token = kToken};
  HttpRequest request = From("192.168.1.5:8717");
  EXPECT_EQ(Decide(rules, request), 403);
  EXPECT_EQ(Decide(rules, request, "/?token="), 403);
  EXPECT_EQ(Decide(rules, request, "/?token=0"), 403);
  EXPECT_EQ(Decide(rules, request, std::string("/?token=") + kToken + "0"),
            403);
  const AccessDecision first = CheckAccess(
      rules, request, *ParseRequestTarget(std::string("/?token=") + kToken));
  EXPECT_EQ(first.status, 200);
  EXPECT_EQ(first.set_cookie,
            std::string("freegs_view_8717=") + kToken +
                "; Path=/; HttpOnly; SameSite=Strict");
  request.cookie = std::string("other=1; freegs_view_8717=") + kToken;
  EXPECT_EQ(Decide(rules, request), 200);
  request.cookie = "freegs_view_8717=00000000000000000000000000000000";
  EXPECT_EQ(Decide(rules, request), 403);
  // Another server's.
  request.cookie = std::string("freegs_view_8718=") + kToken;
  EXPECT_EQ(Decide(rules, request), 403);
}

TEST(Access, PostsOfOtherPagesAreRefused) {
  const AccessRules rules = {.address = "127.0.0.1", .port = 8717};
  HttpRequest request = From("localhost:8717");
  request.method = "POST";
  EXPECT_EQ(Decide(rules, request), 415);
  request.content_type = "application/json; charset=utf-8";
  EXPECT_EQ(Decide(rules, request), 200);
  for (const char* type : {"text/plain", "application/jsonx", "json", ""}) {
    request.content_type = type;
    EXPECT_EQ(Decide(rules, request), 415) << type;
  }
  request.content_type = "Application/JSON";
  request.origin = "http://localhost:8717";
  EXPECT_EQ(Decide(rules, request), 200);
  for (const char* origin : {"null",
                             "http://evil.example",
                             "https://localhost:8717",
                             "http://localhost:8718",
                             "http://localhost:87170"}) {
    request.origin = origin;
    EXPECT_EQ(Decide(rules, request), 403) << origin;
  }
}

TEST(Access, TokensDiffer) {
  const StatusOr<std::string> one = MakeToken();
  const StatusOr<std::string> two = MakeToken();
  ASSERT_TRUE(one.ok() && two.ok());
  EXPECT_EQ(one->size(), 32u);
  EXPECT_NE(*one, *two);
}

TEST(Access, ComparesWholeTexts) {
  EXPECT_TRUE(SameText("", ""));
  EXPECT_TRUE(SameText("token", "token"));
  EXPECT_FALSE(SameText("token", "tokem"));
  EXPECT_FALSE(SameText("token", "Token"));
  EXPECT_FALSE(SameText("token", "toke"));
  EXPECT_FALSE(SameText("", "t"));
}

TEST(Access, FindsACookieByItsWholeName) {
  const std::string header = "ab=1; b=2;a=x=y;\tempty=; last=z";
  EXPECT_EQ(CookieValue(header, "ab"), "1");
  EXPECT_EQ(CookieValue(header, "b"), "2");
  EXPECT_EQ(CookieValue(header, "a"), "x=y");
  EXPECT_EQ(CookieValue(header, "empty"), "");
  EXPECT_EQ(CookieValue(header, "last"), "z");
  EXPECT_EQ(CookieValue(header, "x"), "");
  EXPECT_EQ(CookieValue("", "a"), "");
  EXPECT_EQ(CookieValue(";; a", "a"), "");
}

TEST(Access, AddressesHaveOneForm) {
  for (const auto& [host, address] :
       std::vector<std::pair<std::string, std::string>>{
           {"0", "0.0.0.0"},
           {"127.1", "127.0.0.1"},
           {"::0", "::"},
           {"0:0:0:0:0:0:0:1", "::1"}}) {
    EXPECT_TRUE(IsNumericAddress(host));
    const auto numeric = NumericAddress(host);
    ASSERT_TRUE(numeric.ok()) << numeric.status().message();
    EXPECT_EQ(*numeric, address);
  }
  EXPECT_FALSE(IsNumericAddress("localhost"));
  const auto localhost = NumericAddress("localhost");
  ASSERT_TRUE(localhost.ok()) << localhost.status().message();
  EXPECT_TRUE(IsLoopback(*localhost));
  for (const char* const host : {"fe80::1%lo", "no such host", "1.2.3.4.5"}) {
    EXPECT_EQ(NumericAddress(host).status().code(),
              StatusCode::kInvalidArgument)
        << host;
  }
}

TEST(Access, KnowsLoopback) {
  for (const char* name : {"127.0.0.1", "127.1.2.3", "localhost", "::1"}) {
    EXPECT_TRUE(IsLoopback(name)) << name;
  }
  for (const char* name :
       {"0.0.0.0", "::", "192.168.1.5", "127.evil.example", ""}) {
    EXPECT_FALSE(IsLoopback(name)) << name;
  }
}

}  // namespace
}  // namespace freegs::stages
