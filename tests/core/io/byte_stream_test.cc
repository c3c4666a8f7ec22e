// SPDX-License-Identifier: BSD-3-Clause

#include "core/io/byte_stream.h"

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace freegs {
namespace {

using std::string_literals::operator""s;

TEST(ByteStreamTest, NumbersAreLittleEndianWithoutGaps) {
  ByteWriter writer;
  writer.Put<uint8_t>(1);
  writer.Put<int16_t>(-2);
  writer.Put<uint32_t>(0x01020304);
  writer.Put(1.0f);
  writer.PutArray(std::array<uint16_t, 2>{5, 6});
  EXPECT_EQ(writer.content(),
            "\x01\xfe\xff\x04\x03\x02\x01\x00\x00\x80\x3f\x05\x00\x06\x00"s);
}

TEST(ByteStreamTest, ReadsWhatWasWritten) {
  const std::vector<float> numbers = {0.5f, -3.0f};
  ByteWriter writer;
  writer.PutBytes("MAGIC");
  writer.Put(int64_t{-7});
  writer.PutText("a text");
  writer.PutTerminatedText("name.jpg");
  writer.Put<uint64_t>(numbers.size());
  writer.PutArray(numbers);
  writer.PutArray(std::vector<double>());
  writer.Put(2.25);
  const std::string content = std::move(writer).content();

  ByteReader reader(content);
  int64_t number = 0;
  std::string text;
  std::string name;
  uint64_t count = 0;
  std::vector<float> read;
  double last = 0;
  EXPECT_FALSE(reader.SkipBytes("magic"));
  ASSERT_TRUE(reader.SkipBytes("MAGIC"));
  ASSERT_TRUE(reader.Get(&number));
  ASSERT_TRUE(reader.GetText(&text));
  ASSERT_TRUE(reader.GetTerminatedText(&name));
  ASSERT_TRUE(reader.GetCount(sizeof(float), &count));
  ASSERT_TRUE(reader.GetArray(count, &read));
  EXPECT_FALSE(reader.at_end());
  EXPECT_EQ(reader.remaining(), 8u);
  ASSERT_TRUE(reader.GetArray(1, &last));
  EXPECT_TRUE(reader.at_end());
  EXPECT_EQ(number, -7);
  EXPECT_EQ(text, "a text");
  EXPECT_EQ(name, "name.jpg");
  EXPECT_EQ(read, numbers);
  EXPECT_EQ(last, 2.25);
}

TEST(ByteStreamTest, FailsWhenTruncatedAndTakesNothing) {
  const std::string bytes = "\x01\x02\x03"s;
  ByteReader reader(bytes);
  uint32_t wide = 77;
  std::vector<uint16_t> array = {9};
  std::string text = "as before";
  uint64_t count = 77;
  EXPECT_FALSE(reader.Get(&wide));
  EXPECT_FALSE(reader.GetArray(2, &array));
  EXPECT_FALSE(reader.GetArray(1, &wide));
  EXPECT_FALSE(reader.GetText(&text));
  EXPECT_FALSE(reader.GetTerminatedText(&text));
  EXPECT_FALSE(reader.GetCount(1, &count));
  EXPECT_FALSE(reader.SkipBytes("\x01\x02\x03\x04"));
  EXPECT_EQ(wide, 77u);
  EXPECT_EQ(array, std::vector<uint16_t>{9});
  EXPECT_EQ(text, "as before");
  EXPECT_EQ(count, 77u);
  EXPECT_EQ(reader.remaining(), 3u);
  ASSERT_TRUE(reader.GetArray(1, &array));
  EXPECT_EQ(array, std::vector<uint16_t>{0x0201});
}

// Counts whose products with the size of an element do not fit in 64 bits.
TEST(ByteStreamTest, HostileCountsFailWithoutAllocation) {
  for (const uint64_t count : {uint64_t{3},
                               uint64_t{1} << 40,
                               uint64_t{1} << 61,
                               uint64_t{1} << 62,
                               uint64_t{1} << 63,
                               std::numeric_limits<uint64_t>::max()}) {
    ByteWriter writer;
    writer.Put(count);
    writer.Put(1.0);
    writer.Put(2.0);
    const std::string content = std::move(writer).content();
    std::vector<double> values;
    ByteReader arrays(content);
    ASSERT_TRUE(arrays.SkipBytes(std::string_view(content).substr(0, 8)));
    EXPECT_FALSE(arrays.GetArray(count, &values)) << count;
    EXPECT_EQ(values.capacity(), 0u);
    EXPECT_EQ(arrays.remaining(), 16u);

    uint64_t items = 0;
    std::string text;
    ByteReader reader(content);
    EXPECT_FALSE(reader.GetCount(8, &items)) << count;
    EXPECT_EQ(reader.GetText(&text), count <= 16) << count;
  }
}

TEST(ByteStreamTest, ChecksumNoticesEveryChangedByte) {
  ByteWriter writer;
  writer.PutText("some content");
  writer.PutChecksum();
  std::string content = std::move(writer).content();
  ASSERT_TRUE(HasChecksum(content));
  EXPECT_EQ(WithoutChecksum(content).size(), content.size() - kChecksumBytes);
  for (char& byte : content) {
    byte ^= 1;
    EXPECT_FALSE(HasChecksum(content));
    byte ^= 1;
  }
  for (size_t size = 0; size < content.size(); ++size) {
    EXPECT_FALSE(HasChecksum(std::string_view(content).substr(0, size)));
  }
  ByteWriter empty;
  empty.PutChecksum();
  EXPECT_TRUE(HasChecksum(empty.content()));
}

}  // namespace
}  // namespace freegs
