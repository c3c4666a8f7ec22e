// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/view_selection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::vector<View> Views(const std::vector<std::string>& names) {
  std::vector<View> views;
  for (const std::string& name : names) {
    views.emplace_back();
    views.back().name = name;
  }
  return views;
}

TEST(FindViewTest, ByNameOrByNameWithoutExtension) {
  const std::vector<View> views =
      Views({"left/a.jpg", "right/a.jpg", "b.png", "b.jpg", "c.v2.jpg"});
  EXPECT_EQ(FindView(views, "left/a.jpg")->name, "left/a.jpg");
  EXPECT_EQ(FindView(views, "right/a")->name, "right/a.jpg");
  EXPECT_EQ(FindView(views, "c.v2")->name, "c.v2.jpg");
  EXPECT_EQ(FindView(views, "b.png")->name, "b.png");
  const auto twice = FindView(views, "b");
  EXPECT_EQ(twice.status().code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(twice.status().message(), HasSubstr("several"));
}

TEST(FindViewTest, UnknownNamesListThoseLikeThem) {
  std::vector<std::string> names;
  for (int k = 100; k < 200; ++k) {
    names.push_back("photo" + std::to_string(k) + ".jpg");
  }
  const auto found = FindView(Views(names), "photo1500.jpg");
  EXPECT_EQ(found.status().code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(found.status().message(),
              AllOf(HasSubstr("photo150.jpg"),
                    HasSubstr("of 100"),
                    Not(HasSubstr("photo180.jpg"))));
  EXPECT_FALSE(FindView({}, "a").ok());
  EXPECT_THAT(FindView(Views({"z"}), "").status().message(), HasSubstr("z"));
}

}  // namespace
}  // namespace freegs::stages
