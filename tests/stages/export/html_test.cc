// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/html.h"

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/number_text.h"

namespace freegs::stages {
namespace {

TEST(HtmlTest, EscapesMarkupControlsAndBadUtf8) {
  EXPECT_EQ(EscapeHtml("<a href=\"x\">&'"),
            "&lt;a href=&quot;x&quot;&gt;&amp;&#39;");
  EXPECT_EQ(EscapeHtml("gr\u00fcn\n"), "gr\u00fcn\n");
  EXPECT_EQ(EscapeHtml(std::string("a\0b\x1b", 4)), "a\ufffdb\ufffd");
  EXPECT_EQ(EscapeHtml("a\xff"), "a\ufffd");
}

TEST(HtmlTest, EncodesPaths) {
  EXPECT_EQ(EncodeUrlPath("views/1_photo.jpg"), "views/1_photo.jpg");
  EXPECT_EQ(EncodeUrlPath("javascript:a b\"#?%"),
            "javascript%3Aa%20b%22%23%3F%25");
  EXPECT_EQ(EncodeUrlPath("\xff"), "%FF");
}

TEST(HtmlTest, JsonDoesNotEndItsScript) {
  const nlohmann::json json = {{"</script>", "<!-- a < b -->"}, {"c", 1}};
  const std::string text = JsonForScript(json.dump());
  EXPECT_EQ(text.find('<'), std::string::npos) << text;
  EXPECT_EQ(nlohmann::json::parse(text), json);
  EXPECT_EQ(JsonForScript(R"({"a":"\u003c"})"), R"({"a":"\u003c"})");
}

}  // namespace
}  // namespace freegs::stages
