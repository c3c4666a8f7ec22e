// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/idsf.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <xxhash.h>

#include "tests/temporary_folder.h"

namespace freegs::semantics {
namespace {

Idsf MakeIdsf() {
  return {.feature_dim = 2,
          .features = {0.5f, -1, 2, 3, 1e30f, 0},
          .instances = {-1, 0, 2}};
}

// Puts a value into the content and makes the checksum fit again.
template <typename T>
std::string Patched(std::string content, size_t offset, T value) {
  std::memcpy(content.data() + offset, &value, sizeof(T));
  const size_t end = content.size() - 8;
  const uint64_t checksum = XXH3_64bits(content.data(), end);
  std::memcpy(content.data() + end, &checksum, 8);
  return content;
}

TEST(IdsfTest, ComesBackAsWritten) {
  for (const Idsf& idsf :
       {MakeIdsf(),
        Idsf{.feature_dim = 0, .features = {}, .instances = {1, -1}},
        Idsf{}}) {
    const auto content = SerializeIdsf(idsf);
    ASSERT_TRUE(content.ok());
    const auto read = ParseIdsf(*content);
    ASSERT_TRUE(read.ok()) << read.status().message();
    EXPECT_EQ(read->feature_dim, idsf.feature_dim);
    EXPECT_EQ(read->features, idsf.features);
    EXPECT_EQ(read->instances, idsf.instances);
  }
}

TEST(IdsfTest, ComesBackFromAFile) {
  const TemporaryFolder folder;
  const std::string path = folder / "idsf_test.bin";
  ASSERT_TRUE(WriteIdsf(path, MakeIdsf()).ok());
  const auto read = ReadIdsf(path);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->instances, MakeIdsf().instances);
  const auto missing = ReadIdsf(path + ".none");
  EXPECT_EQ(missing.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(missing.status().message(), testing::HasSubstr("idsf_test"));
}

TEST(IdsfTest, RefusesArraysThatDisagree) {
  Idsf idsf = MakeIdsf();
  idsf.features.pop_back();
  EXPECT_EQ(SerializeIdsf(idsf).status().code(), StatusCode::kInvalidArgument);
  idsf = MakeIdsf();
  idsf.feature_dim = -2;
  EXPECT_FALSE(SerializeIdsf(idsf).ok());
}

TEST(IdsfTest, RefusesEveryTruncationAndExtension) {
  const std::string content = *SerializeIdsf(MakeIdsf());
  for (size_t size = 0; size < content.size(); ++size) {
    EXPECT_EQ(ParseIdsf(content.substr(0, size)).status().code(),
              StatusCode::kBadInput);
  }
  EXPECT_FALSE(ParseIdsf(content + "x").ok());
}

TEST(IdsfTest, RefusesEveryFlippedByte) {
  const std::string content = *SerializeIdsf(MakeIdsf());
  for (size_t i = 0; i < content.size(); ++i) {
    std::string damaged = content;
    damaged[i] ^= 0x40;
    EXPECT_FALSE(ParseIdsf(damaged).ok()) << i;
  }
}

TEST(IdsfTest, RefusesLyingHeadersWithAGoodChecksum) {
  const std::string content = *SerializeIdsf(MakeIdsf());
  EXPECT_FALSE(ParseIdsf(Patched<uint32_t>(content, 8, 2)).ok());
  for (const uint32_t dim : {0u, 1u, 3u, 0x7fffffffu, 0xffffffffu}) {
    EXPECT_FALSE(ParseIdsf(Patched(content, 12, dim)).ok()) << dim;
  }
  for (const uint64_t count :
       {uint64_t{0}, uint64_t{2}, uint64_t{1} << 62, ~uint64_t{0}}) {
    EXPECT_FALSE(ParseIdsf(Patched(content, 16, count)).ok()) << count;
  }
}

TEST(IdsfTest, RefusesValuesOutOfRange) {
  const std::string content = *SerializeIdsf(MakeIdsf());
  // Whoever counts instances by their largest index takes memory for them.
  for (const int32_t index : {-2, 3, 2'000'000'000, 0x7fffffff}) {
    const auto read = ParseIdsf(Patched<int32_t>(content, 24, index));
    EXPECT_EQ(read.status().code(), StatusCode::kBadInput) << index;
  }
  EXPECT_FALSE(
      ParseIdsf(
          Patched(content, 24 + 3 * 4, std::numeric_limits<float>::quiet_NaN()))
          .ok());
}

}  // namespace
}  // namespace freegs::semantics
