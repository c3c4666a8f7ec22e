// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/exposure_file.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_text.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

class ExposureFileTest : public testing::Test {
 protected:
  Status ErrorOf(const std::string& text) {
    EXPECT_TRUE(WriteFileAtomic(path_, text).ok());
    return ReadExposures(path_).status();
  }

  const TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_.path() / "exposure.json";
};

TEST_F(ExposureFileTest, ReadsWhatItWroteInTheOrderOfNames) {
  splat::AffineColor color;
  for (size_t k = 0; k < color.values.size(); ++k) {
    color.values[k] = 0.1f * static_cast<float>(k) - 0.3f;
  }
  ASSERT_TRUE(WriteExposures(path_,
                             std::vector<splat::PhotoExposure>{
                                 {"b/2.jpg", color}, {"a.jpg", {}}})
                  .ok());
  const auto read = ReadExposures(path_);
  ASSERT_TRUE(read.ok()) << read.status().message();
  ASSERT_EQ(read->size(), 2u);
  EXPECT_EQ((*read)[0].photo, "a.jpg");
  EXPECT_EQ((*read)[0].color, splat::AffineColor());
  EXPECT_EQ((*read)[1].photo, "b/2.jpg");
  EXPECT_EQ((*read)[1].color, color);
}

TEST_F(ExposureFileTest, HasTheLayoutOf3dgs) {
  // A photo whose red is 0.9 of the scene's red, 0.2 of its green, and 0.05.
  splat::AffineColor color;
  color.values = {0.9f, 0.2f, 0, 0.05f, 0, 1, 0, 0, 0, 0, 1, 0};
  const std::vector<splat::PhotoExposure> exposures = {{"a.jpg", color}};
  ASSERT_TRUE(WriteExposures(path_, exposures).ok());
  const StatusOr<nlohmann::json> file = ReadJson(path_);
  ASSERT_TRUE(file.ok());
  const nlohmann::json& rows = (*file)["a.jpg"];
  EXPECT_FLOAT_EQ(rows[1][0].get<float>(), 0.2f);
  EXPECT_EQ(rows[0][1].get<float>(), 0);
  EXPECT_FLOAT_EQ(rows[0][3].get<float>(), 0.05f);

  // 3DGS multiplies the colour, as a row, from the left.
  const float scene[] = {0.5f, 0.4f, 0.3f};
  ImageF picture(1, 1, 3);
  std::copy_n(scene, 3, picture.data());
  ThreadPool pool(1);
  const ImageF photo = InExposureOf("a.jpg", exposures, picture, pool);
  for (size_t k = 0; k < 3; ++k) {
    float expected = rows[k][3].get<float>();
    for (size_t j = 0; j < 3; ++j) {
      expected += scene[j] * rows[j][k].get<float>();
    }
    EXPECT_FLOAT_EQ(photo.data()[k], expected) << k;
  }
}

TEST(InExposureOfTest, IsThatOfThePhotoOrOfItsNeighbours) {
  const auto brightness = [](float factor) {
    splat::AffineColor color;
    for (const size_t k : {0u, 5u, 10u}) color.values[k] = factor;
    return color;
  };
  const std::vector<splat::PhotoExposure> exposures = {
      {"a.jpg", brightness(0.5f)}, {"c.jpg", brightness(1.5f)}};
  ThreadPool pool(1);
  const ImageF picture(2, 1, 3, 0.4f);
  const auto value = [&](const std::string& photo) {
    return InExposureOf(photo, exposures, picture, pool)(1, 0, 2);
  };
  EXPECT_FLOAT_EQ(value("a.jpg"), 0.2f);
  EXPECT_FLOAT_EQ(value("b.jpg"), 0.4f);
  EXPECT_FLOAT_EQ(value("c.jpg"), 0.6f);
  EXPECT_EQ(InExposureOf("a.jpg", {}, picture, pool)(1, 0, 2), 0.4f);
}

TEST_F(ExposureFileTest, NoFileIsNoExposure) {
  const auto read = ReadExposures(path_);
  ASSERT_TRUE(read.ok());
  EXPECT_TRUE(read->empty());
}

TEST_F(ExposureFileTest, NamesWhatIsWrong) {
  for (const char* const text : {
           "",
           "[1, 2]",
           "{\"a.jpg\": 3}",
           "{\"a.jpg\": [[1, 0, 0, 0], [0, 1, 0, 0]]}",
           "{\"a.jpg\": [[1, 0, 0, 0], [0, 1, 0], [0, 0, 1, 0]]}",
           "{\"a.jpg\": [[1, 0, 0, 0], [0, 1, 0, null], [0, 0, 1, 0]]}",
           "{\"a.jpg\": [[1, 0, 0, 0], [0, 1, 0, 1e300], [0, 0, 1, 0]]}",
           "{\"a.jpg\": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]",
       }) {
    const Status status = ErrorOf(text);
    EXPECT_EQ(status.code(), StatusCode::kBadInput) << text;
    EXPECT_THAT(status.message(), testing::HasSubstr("exposure.json"));
  }
}

}  // namespace
}  // namespace freegs::stages
