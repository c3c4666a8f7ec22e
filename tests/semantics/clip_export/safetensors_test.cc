// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip_export/safetensors.h"

#include <limits>

#include <Eigen/Core>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/semantics/clip_export/random_clip.h"

namespace freegs::semantics {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class SafetensorsTest : public testing::Test {
 protected:
  StatusOr<SafetensorsFile> Open(const std::string& bytes) const {
    folder_.Write("a.safetensors", bytes);
    return SafetensorsFile::Open(folder_ / "a.safetensors");
  }

  void ExpectFault(const std::string& bytes, const std::string& fault) const {
    const auto file = Open(bytes);
    ASSERT_FALSE(file.ok()) << fault;
    EXPECT_EQ(file.status().code(), StatusCode::kMissingDependency);
    EXPECT_THAT(file.status().message(),
                AllOf(HasSubstr("a.safetensors"), HasSubstr(fault)));
  }

  const TemporaryFolder folder_;
};

TEST_F(SafetensorsTest, ReadsTensors) {
  const auto file = Open(SafetensorsBytes(
      {{"a", {{2, 3}, {1, 2, 3, 4, 5, 6}}}, {"b", {{}, {7}}}}));
  ASSERT_TRUE(file.ok()) << file.status().message();
  EXPECT_EQ(file->tensors().size(), 2u);
  EXPECT_THAT(*file->Read("a", {2, 3}), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(*file->Read("b", {}), ElementsAre(7));
  EXPECT_THAT(file->Read("a", {3, 2}).status().message(),
              AllOf(HasSubstr("a.safetensors"), HasSubstr("2 x 3, not 3 x 2")));
  EXPECT_THAT(file->Read("c", {1}).status().message(),
              HasSubstr("no tensor c"));
}

TEST_F(SafetensorsTest, ReadsHalfPrecision) {
  std::string data;
  const auto append = [&data](const auto& value) {
    data.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  append(Eigen::half(0.333f));
  append(Eigen::half(-6e-8f));  // Subnormal.
  append(Eigen::bfloat16(1e30f));
  append(int64_t{3});
  const auto file = Open(SafetensorsBytes(
      R"({"h":{"dtype":"F16","shape":[2],"data_offsets":[0,4]},
          "b":{"dtype":"BF16","shape":[1],"data_offsets":[4,6]},
          "i":{"dtype":"I64","shape":[1],"data_offsets":[6,14]}})",
      data));
  ASSERT_TRUE(file.ok()) << file.status().message();
  const auto halves = file->Read("h", {2});
  EXPECT_NEAR(halves->at(0), 0.333, 2e-4);
  EXPECT_NEAR(halves->at(1), -6e-8, 1e-9);
  EXPECT_NEAR(file->Read("b", {1})->at(0) / 1e30, 1, 0.01);
  EXPECT_THAT(file->Read("i", {1}).status().message(),
              HasSubstr("has the type I64"));
}

TEST_F(SafetensorsTest, NumbersMustBeFinite) {
  const auto file = Open(SafetensorsBytes(
      {{"a", {{1}, {std::numeric_limits<float>::quiet_NaN()}}}}));
  ASSERT_TRUE(file.ok());
  EXPECT_THAT(file->Read("a", {1}).status().message(), HasSubstr("finite"));
}

TEST_F(SafetensorsTest, HugeTensorsAreNotRead) {
  const std::string header = SafetensorsBytes(
      R"({"a":{"dtype":"F16","shape":[1073741824],
          "data_offsets":[0,2147483648]}})",
      "");
  folder_.Write("a.safetensors", header);
  // The rest is a hole, which takes no space.
  std::filesystem::resize_file(folder_ / "a.safetensors",
                               header.size() + 2147483648);
  const auto file = SafetensorsFile::Open(folder_ / "a.safetensors");
  ASSERT_TRUE(file.ok()) << file.status().message();
  EXPECT_THAT(file->Read("a", {1073741824}).status().message(),
              AllOf(HasSubstr("a.safetensors"), HasSubstr("larger than")));
}

TEST_F(SafetensorsTest, RefusesDamage) {
  const std::string good =
      SafetensorsBytes({{"a", {{2}, {1, 2}}}, {"b", {{1}, {3}}}});
  ASSERT_TRUE(Open(good).ok());
  for (size_t size = 0; size < good.size(); ++size) {
    ExpectFault(good.substr(0, size), "");
  }
  ExpectFault(good + "x", "belong to no tensor");
  std::string huge = good;
  huge[6] = 1;
  ExpectFault(huge, "longer than the file");
  for (size_t i = 0; i < good.size() - 12; ++i) {
    std::string flipped = good;
    flipped[i] = static_cast<char>(flipped[i] ^ 0x10);
    Open(flipped).ok();  // Some are still good; none must crash.
  }
  EXPECT_THAT(SafetensorsFile::Open(folder_ / "none").status().message(),
              HasSubstr("no such file"));
  EXPECT_THAT(SafetensorsFile::Open(folder_.path()).status().message(),
              HasSubstr("not a regular file"));
}

TEST_F(SafetensorsTest, RefusesLies) {
  const auto with = [](const std::string& entry) {
    return SafetensorsBytes("{\"a\":" + entry + "}", std::string(8, '\0'));
  };
  const std::string f32 = R"({"dtype":"F32",)";
  ExpectFault(with("3"), "tensor a");
  ExpectFault(with(f32 + R"("shape":[3],"data_offsets":[0,8]})"),
              "8 bytes are not 3 elements");
  ExpectFault(with(f32 + R"("shape":[2],"data_offsets":[8,0]})"),
              "data_offsets");
  ExpectFault(with(f32 + R"("shape":[2],"data_offsets":[-8,0]})"),
              "data_offsets");
  ExpectFault(with(f32 + R"("shape":[2],"data_offsets":[0]})"), "data_offsets");
  ExpectFault(with(f32 + R"("shape":[-2],"data_offsets":[0,8]})"), "shape");
  ExpectFault(with(f32 + R"("shape":["2"],"data_offsets":[0,8]})"), "shape");
  ExpectFault(with(f32 + R"("shape":[1,1,1,1,1,1,1,1,2],
                            "data_offsets":[0,8]})"),
              "too many sides");
  ExpectFault(with(f32 + R"("shape":[1099511627776,1099511627776],
                            "data_offsets":[0,8]})"),
              "too large");
  ExpectFault(with(f32 + R"("shape":[2],"data_offsets":[4,12]})"),
              "behind the end");
  ExpectFault(with(f32 + R"("shape":[1],"data_offsets":[4,8]})"), "a gap");
  ExpectFault(with(R"({"dtype":"C64","shape":[1],"data_offsets":[0,8]})"),
              "not a known type");
  const std::string two = R"("shape":[2],"data_offsets":[0,8]})";
  ExpectFault(with(f32 + two + ",\"b\":" + f32 + two), "overlaps");
  ExpectFault(SafetensorsBytes("[]", ""), "must be an object");
  ExpectFault(SafetensorsBytes(std::string(100000, '['), ""), "nested deeper");
  ExpectFault(SafetensorsBytes(std::string((1 << 24) + 1, ' '), ""),
              "larger than that of any CLIP");
}

}  // namespace
}  // namespace freegs::semantics
