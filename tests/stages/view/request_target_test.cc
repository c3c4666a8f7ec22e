// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/request_target.h"

#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

using namespace std::string_literals;

TEST(RequestTarget, DecodesPathAndParameters) {
  const auto target = ParseRequestTarget(
      "/api/photos/a%20%26%27%C3%BC/b%2Fc.jpg?v=1&q=%3D&z&v=2");
  ASSERT_TRUE(target.has_value());
  EXPECT_EQ(target->path, "/api/photos/a &'\xc3\xbc/b/c.jpg");
  EXPECT_EQ(target->parameters.at("v"), "1");
  EXPECT_EQ(target->parameters.at("q"), "=");
  EXPECT_EQ(target->parameters.at("z"), "");
  EXPECT_EQ(ParseRequestTarget("/")->path, "/");
  EXPECT_EQ(ParseRequestTarget("/report/")->path, "/report/");
  // Decoded once only.
  EXPECT_EQ(ParseRequestTarget("/%252e%252e")->path, "/%2e%2e");
}

TEST(RequestTarget, RefusesPathsThatAreNotPlain) {
  for (const std::string& target : {""s,
                                    "report"s,
                                    "*"s,
                                    "http://x/report/"s,
                                    "/.."s,
                                    "/../x"s,
                                    "/report/../../x"s,
                                    "/./x"s,
                                    "/%2e%2e/x"s,
                                    "/.%2E/x"s,
                                    "/%2e%2e%2fx"s,
                                    "/..%2fx"s,
                                    "/..\\x"s,
                                    "/..%5Cx"s,
                                    "//x"s,
                                    "/x//y"s,
                                    "/%2fetc/passwd"s,
                                    "/x%00.jpg"s,
                                    "/x\0.jpg"s,
                                    "/x%0a"s,
                                    "/x%7f"s,
                                    "/x%"s,
                                    "/x%2"s,
                                    "/x%zz"s,
                                    "/x%+2"s,
                                    "/x?a=%"s}) {
    EXPECT_FALSE(ParseRequestTarget(target).has_value()) << target;
  }
}

}  // namespace
}  // namespace freegs::stages
