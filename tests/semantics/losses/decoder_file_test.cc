// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/decoder_file.h"

#include <cstring>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <xxhash.h>

#include "tests/semantics/losses/gradient_check.h"
#include "tests/temporary_folder.h"

namespace freegs::semantics {
namespace {

constexpr size_t kHeaderSize = 32;

StoredDecoder Linear() {
  return {FeatureDecoder(LinearDecoder{.latent_dim = 2,
                                       .feature_dim = 3,
                                       .basis = RandomValues(6, 1),
                                       .mean = RandomValues(3, 2)}),
          std::nullopt};
}

StoredDecoder Mlp() {
  MlpDecoder mlp = RandomMlpDecoder({2, 3, 4}, 1);
  mlp.running_means = RandomValues(3, 2);
  return {FeatureDecoder(mlp), std::nullopt};
}

StoredDecoder MlpWithAdam() {
  StoredDecoder stored = Mlp();
  const size_t size = stored.decoder.mlp()->parameters.size();
  stored.adam =
      ArrayAdamState{7, RandomValues(size, 3), std::vector<float>(size, 0.25f)};
  return stored;
}

std::vector<StoredDecoder> AllKinds() {
  return {Linear(), Mlp(), MlpWithAdam()};
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

TEST(DecoderFileTest, LinearComesBackAsWritten) {
  const LinearDecoder before = *Linear().decoder.linear();
  const auto read = ParseDecoder(*SerializeDecoder(Linear()));
  ASSERT_TRUE(read.ok()) << read.status().message();
  ASSERT_TRUE(read->decoder.linear());
  EXPECT_EQ(read->decoder.linear()->latent_dim, 2);
  EXPECT_EQ(read->decoder.linear()->feature_dim, 3);
  EXPECT_EQ(read->decoder.linear()->basis, before.basis);
  EXPECT_EQ(read->decoder.linear()->mean, before.mean);
  EXPECT_FALSE(read->adam);
}

TEST(DecoderFileTest, MlpComesBackAsWritten) {
  for (const StoredDecoder& stored : {Mlp(), MlpWithAdam()}) {
    const auto read = ParseDecoder(*SerializeDecoder(stored));
    ASSERT_TRUE(read.ok()) << read.status().message();
    const MlpDecoder* before = stored.decoder.mlp();
    const MlpDecoder* after = read->decoder.mlp();
    ASSERT_TRUE(after);
    EXPECT_EQ(after->shape.latent_dim, 2);
    EXPECT_EQ(after->shape.hidden_dim, 3);
    EXPECT_EQ(after->shape.feature_dim, 4);
    EXPECT_EQ(after->parameters, before->parameters);
    EXPECT_EQ(after->running_means, before->running_means);
    EXPECT_EQ(after->running_variances, before->running_variances);
    ASSERT_EQ(read->adam.has_value(), stored.adam.has_value());
    if (!stored.adam) continue;
    EXPECT_EQ(read->adam->steps, stored.adam->steps);
    EXPECT_EQ(read->adam->first_moments, stored.adam->first_moments);
    EXPECT_EQ(read->adam->second_moments, stored.adam->second_moments);
  }
}

TEST(DecoderFileTest, ComesBackFromAFile) {
  const TemporaryFolder folder;
  const std::string path = folder / "decoder_file_test.bin";
  ASSERT_TRUE(WriteDecoder(path, MlpWithAdam()).ok());
  EXPECT_TRUE(ReadDecoder(path).ok());
  const auto missing = ReadDecoder(path + ".none");
  EXPECT_EQ(missing.status().code(), StatusCode::kBadInput);
  EXPECT_THAT(missing.status().message(),
              testing::HasSubstr("decoder_file_test"));
}

TEST(DecoderFileTest, RefusesToWriteWhatItWouldNotRead) {
  StoredDecoder stored = Linear();
  stored.adam = ArrayAdamState();
  EXPECT_EQ(SerializeDecoder(stored).status().code(),
            StatusCode::kInvalidArgument);
  stored = MlpWithAdam();
  stored.adam->first_moments.pop_back();
  EXPECT_FALSE(SerializeDecoder(stored).ok());
  stored = MlpWithAdam();
  stored.decoder.mlp()->parameters[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(SerializeDecoder(stored).ok());
}

TEST(DecoderFileTest, RefusesEveryTruncationAndExtension) {
  for (const StoredDecoder& stored : AllKinds()) {
    const std::string content = *SerializeDecoder(stored);
    for (size_t size = 0; size < content.size(); ++size) {
      EXPECT_EQ(ParseDecoder(content.substr(0, size)).status().code(),
                StatusCode::kBadInput);
    }
    EXPECT_FALSE(ParseDecoder(content + "x").ok());
    // Whole numbers less or more, with a good checksum.
    for (const size_t size : {content.size() - 4, content.size() + 4}) {
      std::string other = content;
      other.resize(size, '\0');
      EXPECT_FALSE(ParseDecoder(Patched(other, 8, uint32_t{1})).ok());
    }
  }
}

TEST(DecoderFileTest, RefusesEveryFlippedByte) {
  for (const StoredDecoder& stored : AllKinds()) {
    const std::string content = *SerializeDecoder(stored);
    for (size_t i = 0; i < content.size(); ++i) {
      std::string damaged = content;
      damaged[i] ^= 0x40;
      EXPECT_FALSE(ParseDecoder(damaged).ok()) << i;
    }
  }
}

TEST(DecoderFileTest, RefusesLyingHeadersWithAGoodChecksum) {
  for (const StoredDecoder& stored : AllKinds()) {
    const std::string content = *SerializeDecoder(stored);
    for (size_t offset = 8; offset < kHeaderSize; offset += 4) {
      uint32_t is = 0;
      std::memcpy(&is, content.data() + offset, 4);
      for (const uint32_t value : {0u,
                                   1u,
                                   2u,
                                   3u,
                                   5u,
                                   65536u,
                                   65537u,
                                   0x7fffffffu,
                                   0x80000000u,
                                   0xffffffffu}) {
        if (value == is) continue;
        const auto read = ParseDecoder(Patched(content, offset, value));
        EXPECT_EQ(read.status().code(), StatusCode::kBadInput)
            << offset << " " << value;
      }
    }
    std::string largest = content;
    for (size_t offset = 16; offset < 28; offset += 4) {
      largest = Patched(largest, offset, 65536u);
    }
    EXPECT_FALSE(ParseDecoder(largest).ok());
  }
}

TEST(DecoderFileTest, RefusesValuesOutOfRange) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const StoredDecoder& stored : AllKinds()) {
    EXPECT_FALSE(
        ParseDecoder(Patched(*SerializeDecoder(stored), kHeaderSize, nan))
            .ok());
  }
  const StoredDecoder stored = MlpWithAdam();
  const std::string content = *SerializeDecoder(stored);
  const size_t parameters = stored.decoder.mlp()->parameters.size();
  const size_t variances = kHeaderSize + 4 * (parameters + 3);
  EXPECT_FALSE(ParseDecoder(Patched(content, variances, -1.0f)).ok());
  const size_t steps = variances + 12;
  for (const int64_t bad : {int64_t{-1}, std::numeric_limits<int64_t>::max()}) {
    EXPECT_FALSE(ParseDecoder(Patched(content, steps, bad)).ok());
  }
  EXPECT_TRUE(ParseDecoder(Patched(content, steps, int64_t{9})).ok());
  EXPECT_FALSE(ParseDecoder(Patched(content, steps + 8, nan)).ok());
  const size_t second = steps + 8 + 4 * parameters;
  EXPECT_FALSE(ParseDecoder(Patched(content, second, -0.5f)).ok());
}

}  // namespace
}  // namespace freegs::semantics
