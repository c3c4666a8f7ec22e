// SPDX-License-Identifier: BSD-3-Clause

#include "core/io/gzip.h"

#include <string>

#include <gtest/gtest.h>

namespace freegs {
namespace {

TEST(GzipTest, UnpacksWhatWasPacked) {
  for (const std::string& text :
       {std::string(), std::string("a"), std::string(1 << 20, 'x')}) {
    const std::string packed = Gzip(text).value();
    EXPECT_TRUE(IsGzip(packed));
    const auto unpacked = Gunzip(packed, 1 << 20);
    ASSERT_TRUE(unpacked.ok()) << unpacked.status().message();
    EXPECT_EQ(*unpacked, text);
  }
  EXPECT_FALSE(IsGzip(""));
  EXPECT_FALSE(IsGzip("text"));
}

TEST(GzipTest, RefusesDamage) {
  const std::string text = "some text to pack, some text to pack";
  const std::string packed = Gzip(text).value();
  for (size_t size = 0; size < packed.size(); ++size) {
    EXPECT_EQ(Gunzip(packed.substr(0, size), 1 << 20).status().code(),
              StatusCode::kBadInput);
  }
  EXPECT_FALSE(Gunzip(packed + "x", 1 << 20).ok());
  // The header's time and system (bytes 4 .. 9) are not covered by anything.
  for (size_t i = 10; i < packed.size(); ++i) {
    std::string damaged = packed;
    damaged[i] ^= 0x10;
    // Bits that only fill up the last byte can change without harm.
    const auto unpacked = Gunzip(damaged, 1 << 20);
    EXPECT_TRUE(!unpacked.ok() || *unpacked == text) << i;
  }
}

TEST(GzipTest, RefusesBombs) {
  const std::string packed = Gzip(std::string(10 << 20, '\0')).value();
  EXPECT_LT(packed.size(), 20000u);
  const auto unpacked = Gunzip(packed, 1 << 20);
  EXPECT_EQ(unpacked.status().code(), StatusCode::kBadInput);
}

TEST(GzipTest, UnpacksOnlyTheBeginning) {
  const std::string packed = Gzip(std::string(10 << 20, 'x')).value();
  EXPECT_EQ(GunzipBeginning(packed, 5).value(), "xxxxx");
  EXPECT_EQ(GunzipBeginning(packed.substr(0, 100), 5).value(), "xxxxx");
  EXPECT_EQ(GunzipBeginning(Gzip("ab").value(), 5).value(), "ab");
  EXPECT_EQ(GunzipBeginning(packed.substr(0, 5), 5).status().code(),
            StatusCode::kBadInput);
}

TEST(GzipTest, SameBytesEveryTime) {
  EXPECT_EQ(Gzip("some text").value(), Gzip("some text").value());
}

}  // namespace
}  // namespace freegs
