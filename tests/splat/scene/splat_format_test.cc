// SPDX-License-Identifier: BSD-3-Clause

#include "splat/scene/splat_format.h"

#include <cmath>
#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include "tests/splat/random_model.h"

namespace freegs::splat {
namespace {

float FloatAt(const std::string& content, size_t at) {
  float value = 0;
  std::memcpy(&value, content.data() + at, sizeof(value));
  return value;
}

int ByteAt(const std::string& content, size_t at) {
  return static_cast<unsigned char>(content[at]);
}

TEST(SplatFormatTest, RecordLayout) {
  GaussianModel model;
  model.Resize(1);
  model.means = {1, -2, 3};
  model.log_scales = {0, std::log(2.0f), -1};
  model.rotations = {0, 0, -2, 0};
  model.opacity_logits = {0};
  model.sh_dc = {0, 100, -0.5f / kShC0};
  const std::string content = SerializeSplat(model);
  ASSERT_EQ(content.size(), 32u);
  EXPECT_EQ(FloatAt(content, 0), 1.0f);
  EXPECT_EQ(FloatAt(content, 4), -2.0f);
  EXPECT_EQ(FloatAt(content, 12), 1.0f);
  EXPECT_FLOAT_EQ(FloatAt(content, 16), 2.0f);
  EXPECT_FLOAT_EQ(FloatAt(content, 20), std::exp(-1.0f));
  EXPECT_EQ(ByteAt(content, 24), 128);
  EXPECT_EQ(ByteAt(content, 25), 255);
  EXPECT_EQ(ByteAt(content, 26), 0);
  EXPECT_EQ(ByteAt(content, 27), 128);
  EXPECT_EQ(ByteAt(content, 28), 128);
  EXPECT_EQ(ByteAt(content, 30), 0);
}

TEST(SplatFormatTest, ImportantOnesFirst) {
  GaussianModel model;
  model.Resize(3);
  model.means = {0, 0, 0, 1, 0, 0, 2, 0, 0};
  model.log_scales = {0, 0, 0, 1, 1, 1, 0, 0, 0};
  model.opacity_logits = {0, 0, 5};
  const std::string content = SerializeSplat(model);
  EXPECT_EQ(FloatAt(content, 0), 1.0f);
  EXPECT_EQ(FloatAt(content, 32), 2.0f);
  EXPECT_EQ(FloatAt(content, 64), 0.0f);
}

TEST(SplatFormatTest, HugeAndFaintOnesHaveAnOrder) {
  GaussianModel model;
  model.Resize(3);
  model.log_scales = {0, 0, 0, 300, 300, 300, -300, -300, -300};
  model.opacity_logits = {0, -800, 800};
  const std::string content = SerializeSplat(model);
  ASSERT_EQ(content.size(), 3u * 32);
  float deviations[3];
  for (int i = 0; i < 3; ++i) {
    std::memcpy(&deviations[i], content.data() + 32 * i + 12, sizeof(float));
  }
  EXPECT_TRUE(std::isfinite(deviations[0]));
  EXPECT_GT(deviations[0], 1e38f);
  EXPECT_EQ(deviations[1], 1);
  EXPECT_EQ(deviations[2], 0);
}

TEST(SplatFormatTest, EmptyModel) {
  EXPECT_TRUE(SerializeSplat(GaussianModel()).empty());
}

}  // namespace
}  // namespace freegs::splat
