// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/feature_cache.h"

#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <limits>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <xxhash.h>

#include "tests/temporary_folder.h"

namespace freegs::semantics {
namespace {

using testing::HasSubstr;

ImageF Features() {
  ImageF features(3, 2, 4);
  for (size_t i = 0; i < features.size(); ++i) {
    features.data()[i] = static_cast<float>(i) / 7 - 1;
  }
  return features;
}

class FeatureCacheTest : public testing::Test {
 protected:
  CachedFeatures Find(const std::string& image = "image",
                      const std::string& model = "model",
                      const std::string& kind = "dense 224") const {
    return cache_.Find(image, model, kind);
  }
  Status Store(const ImageF& features) const {
    return cache_.Store("image", "model", "dense 224", features);
  }
  std::filesystem::path File() const {
    return cache_.FileOf("image", "model", "dense 224");
  }

  TemporaryFolder folder_;
  FeatureCache cache_{folder_ / "features"};
};

TEST_F(FeatureCacheTest, FindsWhatWasStored) {
  EXPECT_FALSE(Find().features);
  EXPECT_EQ(Find().reason, "not kept yet");
  ASSERT_TRUE(Store(Features()).ok());
  const CachedFeatures found = Find();
  ASSERT_TRUE(found.features) << found.reason;
  EXPECT_EQ(found.features->width(), 3);
  EXPECT_EQ(found.features->height(), 2);
  EXPECT_EQ(found.features->channels(), 4);
  for (size_t i = 0; i < found.features->size(); ++i) {
    EXPECT_NEAR(found.features->data()[i], Features().data()[i], 1e-3);
  }
  // Nothing temporary is left.
  int files = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(folder_ / "features")) {
    EXPECT_EQ(entry.path(), File());
    ++files;
  }
  EXPECT_EQ(files, 1);
}

TEST_F(FeatureCacheTest, AnotherImageModelOrKindIsAMiss) {
  ASSERT_TRUE(Store(Features()).ok());
  EXPECT_FALSE(Find("image2").features);
  EXPECT_FALSE(Find("image", "model2").features);
  EXPECT_FALSE(Find("image", "model", "dense 448").features);
  EXPECT_FALSE(Find("image model", "", "dense 224").features);
  EXPECT_FALSE(Find("", "image model", "dense 224").features);
  EXPECT_TRUE(Find().features);
}

TEST_F(FeatureCacheTest, NamesMayBeAnyText) {
  const std::string names[] = {"", "../../x", "/etc", std::string("a\0b", 3)};
  for (const std::string& name : names) {
    ASSERT_TRUE(cache_.Store(name, name, name, Features()).ok());
    EXPECT_TRUE(cache_.Find(name, name, name).features);
    EXPECT_EQ(cache_.FileOf(name, name, name).parent_path(),
              folder_ / "features");
  }
}

TEST_F(FeatureCacheTest, ADamagedFileIsAMissWithAReason) {
  ASSERT_TRUE(Store(Features()).ok());
  const std::string content = ReadText(File());
  for (size_t size = 0; size < content.size(); ++size) {
    WriteText(File(), content.substr(0, size));
    ASSERT_FALSE(Find().features) << size;
    ASSERT_THAT(Find().reason, HasSubstr(File().string()));
  }
  for (size_t i = 0; i < content.size(); ++i) {
    std::string damaged = content;
    damaged[i] ^= 0x20;
    WriteText(File(), damaged);
    ASSERT_FALSE(Find().features) << i;
  }
  WriteText(File(), content + "x");
  EXPECT_FALSE(Find().features);
  std::filesystem::remove(File());
  std::filesystem::create_directory(File());
  EXPECT_FALSE(Find().features);
  EXPECT_THAT(Find().reason, HasSubstr("not a regular file"));
}

TEST_F(FeatureCacheTest, ALyingHeaderWithAGoodChecksumIsAMiss) {
  ASSERT_TRUE(Store(Features()).ok());
  const std::string content = ReadText(File());
  for (const size_t offset : {8, 12, 16, 20, 24}) {
    for (const uint32_t value :
         {0u, 5u, 0xffffu, 0x10000u, 0x7fffffffu, 0xffffffffu}) {
      std::string damaged = content;
      std::memcpy(damaged.data() + offset, &value, 4);
      const size_t end = damaged.size() - 8;
      const uint64_t checksum = XXH3_64bits(damaged.data(), end);
      std::memcpy(damaged.data() + end, &checksum, 8);
      WriteText(File(), damaged);
      EXPECT_FALSE(Find().features) << offset << " " << value;
    }
  }
}

TEST_F(FeatureCacheTest, ARenamedFileIsAMiss) {
  ASSERT_TRUE(Store(Features()).ok());
  std::filesystem::rename(File(), cache_.FileOf("other", "model", "dense 224"));
  EXPECT_THAT(Find("other").reason, HasSubstr("another image or model"));
}

TEST_F(FeatureCacheTest, RefusesWhatCannotBeKept) {
  EXPECT_EQ(Store(ImageF()).code(), StatusCode::kInvalidArgument);
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity(),
                          1e5f}) {
    ImageF features = Features();
    features.data()[7] = bad;
    EXPECT_EQ(Store(features).code(), StatusCode::kInvalidArgument);
  }
  EXPECT_FALSE(Find().features);
  WriteText(folder_ / "file", "");
  EXPECT_EQ(
      FeatureCache(folder_ / "file").Store("a", "b", "c", Features()).code(),
      StatusCode::kInternal);
}

TEST_F(FeatureCacheTest, SeveralMayStoreTheSame) {
  std::vector<std::thread> threads;
  std::atomic<int> failures = 0;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 20; ++i) {
        if (!Store(Features()).ok() || !Find().features) ++failures;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(failures, 0);
  // Nothing temporary is left.
  const std::filesystem::directory_iterator files(folder_ / "features");
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
}

// Counts how often it is asked.
class CountingEncoder : public ClipEncoder {
 public:
  int embedding_dim() const override { return 4; }
  const std::string& model_hash() const override { return hash; }
  std::vector<int> dense_sizes() const override { return {224, 448}; }
  StatusOr<std::vector<float>> EncodeImage(const ImageU8&) override {
    return InternalError("not for this test");
  }
  StatusOr<ImageF> EncodeDense(const ImageU8&, int) override {
    ++calls;
    return Features();
  }
  int upsampled_size() const override { return 0; }
  StatusOr<ImageF> Upsample(const ImageF&, const ImageU8&) override {
    return InternalError("not for this test");
  }
  StatusOr<TextEmbedding> EncodeText(const std::string&) override {
    return InternalError("not for this test");
  }

  std::string hash = "model";
  int calls = 0;
};

TEST_F(FeatureCacheTest, EncodesOncePerImageModelAndSize) {
  CountingEncoder encoder;
  const ImageU8 image(4, 4, 3);
  const auto first = EncodeDenseCached(encoder, cache_, "image", image);
  ASSERT_TRUE(first.ok()) << first.status().message();
  const auto second = EncodeDenseCached(encoder, cache_, "image", image, 224);
  ASSERT_TRUE(second.ok());
  EXPECT_EQ(encoder.calls, 1);
  EXPECT_TRUE(
      std::equal(first->data(), first->data() + first->size(), second->data()));
  ASSERT_TRUE(EncodeDenseCached(encoder, cache_, "image", image, 448).ok());
  EXPECT_EQ(encoder.calls, 2);
  ASSERT_TRUE(EncodeDenseCached(encoder, cache_, "image2", image).ok());
  EXPECT_EQ(encoder.calls, 3);
  encoder.hash = "model2";
  ASSERT_TRUE(EncodeDenseCached(encoder, cache_, "image", image).ok());
  EXPECT_EQ(encoder.calls, 4);
  // A damaged file is made anew.
  encoder.hash = "model";
  WriteText(File(), "damaged");
  ASSERT_TRUE(EncodeDenseCached(encoder, cache_, "image", image).ok());
  EXPECT_EQ(encoder.calls, 5);
  EXPECT_TRUE(Find().features);
}

}  // namespace
}  // namespace freegs::semantics
