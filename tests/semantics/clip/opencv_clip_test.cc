// SPDX-License-Identifier: BSD-3-Clause
// Compares with what PyTorch made of the same checkpoint: of the small model
// beside this file, and of the folder that FREEGS_CLIP_MODEL names if it does
// (scripts/check_clip_export.py).

#include "semantics/clip/opencv_clip.h"

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <span>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "core/parallel.h"
#include "semantics/clip/relevancy.h"
#include "tests/semantics/clip/model_files.h"

namespace freegs::semantics {
namespace {

using nlohmann::json;
using testing::HasSubstr;

double Norm(std::span<const float> a) {
  double sum = 0;
  for (const float value : a) sum += static_cast<double>(value) * value;
  return std::sqrt(sum);
}

double Cosine(std::span<const float> a, std::span<const float> b) {
  double dot = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    dot += static_cast<double>(a[i]) * b[i];
  }
  return dot / (Norm(a) * Norm(b));
}

void CompareWithReference(const std::filesystem::path& folder) {
  const json reference = json::parse(ReadText(folder / "reference.json"));
  const auto image = ReadRgb(folder / "reference.png");
  ASSERT_TRUE(image.ok()) << image.status().message();
  const auto clip = OpenCvClip::Open(folder);
  ASSERT_TRUE(clip.ok()) << clip.status().message();
  OpenCvClip& encoder = **clip;
  const auto dim = static_cast<size_t>(encoder.embedding_dim());

  const auto global = encoder.EncodeImage(*image);
  ASSERT_TRUE(global.ok()) << global.status().message();
  const auto expected = reference["image"].get<std::vector<float>>();
  ASSERT_EQ(global->size(), dim);
  ASSERT_EQ(expected.size(), dim);
  EXPECT_NEAR(Norm(*global), 1, 1e-5);
  const double image_cosine = Cosine(*global, expected);
  EXPECT_GT(image_cosine, 0.9999);
  std::cout << "image: 1 - cosine " << 1 - image_cosine << "\n";

  ASSERT_EQ(reference["dense"].size(), encoder.dense_sizes().size());
  for (const json& entry : reference["dense"]) {
    const int size = entry["image_size"];
    const auto dense = encoder.EncodeDense(*image, size);
    ASSERT_TRUE(dense.ok()) << dense.status().message();
    const auto features = entry["features"].get<std::vector<float>>();
    ASSERT_EQ(dense->size(), features.size());
    double worst = 1;
    for (size_t i = 0; i < features.size(); i += dim) {
      const std::span<const float> cell(dense->data() + i, dim);
      const std::span<const float> wanted(features.data() + i, dim);
      worst = std::min(worst, Cosine(cell, wanted));
      EXPECT_NEAR(Norm(cell), Norm(wanted), 1e-3 * Norm(wanted));
    }
    EXPECT_GT(worst, 0.9999);
    std::cout << "dense " << size << ": worst 1 - cosine " << 1 - worst << "\n";
  }

  double worst = 1;
  for (const json& entry : reference["texts"]) {
    const auto text = encoder.EncodeText(entry["text"]);
    ASSERT_TRUE(text.ok()) << text.status().message();
    const auto wanted = entry["embedding"].get<std::vector<float>>();
    ASSERT_EQ(text->values.size(), wanted.size());
    EXPECT_NEAR(Norm(text->values), 1, 1e-5);
    worst = std::min(worst, Cosine(text->values, wanted));
    EXPECT_EQ(text->truncated,
              entry["text"].get<std::string>().size() > 300 &&
                  entry["ids"].size() ==
                      static_cast<size_t>(encoder.info().context_length));
  }
  EXPECT_GT(worst, 0.9999);
  std::cout << "texts: worst 1 - cosine " << 1 - worst << "\n";
}

TEST(OpenCvClipTest, MatchesPyTorch) { CompareWithReference(TinyClip()); }

TEST(OpenCvClipTest, NamedModelMatchesPyTorch) {
  const char* folder = std::getenv("FREEGS_CLIP_MODEL");
  if (folder == nullptr) GTEST_SKIP() << "FREEGS_CLIP_MODEL is not set";
  CompareWithReference(folder);
}

TEST(OpenCvClipTest, CallsDoNotDisturbEachOther) {
  const auto clip = OpenCvClip::Open(TinyClip());
  ASSERT_TRUE(clip.ok());
  const auto image = ReadRgb(TinyClip() / "reference.png");
  ASSERT_TRUE(image.ok());
  const ImageU8 grey(40, 30, 3, 128);
  const auto first = (*clip)->EncodeImage(*image);
  const auto text = (*clip)->EncodeText("red apple");
  ASSERT_TRUE(text.ok());
  EXPECT_TRUE(text->has_words);
  ASSERT_TRUE((*clip)->EncodeImage(grey).ok());
  ASSERT_TRUE((*clip)->EncodeDense(grey).ok());
  ASSERT_TRUE((*clip)->EncodeText("photo").ok());
  // A no-break space, an ideographic space and an entity are no words either.
  for (const char* nothing : {"", "  ", "\u00a0", "\u3000", "&nbsp;"}) {
    const auto blank = (*clip)->EncodeText(nothing);
    ASSERT_TRUE(blank.ok()) << nothing;
    EXPECT_FALSE(blank->has_words) << nothing;
    EXPECT_EQ(EncodeWords(nothing, **clip).status().code(),
              StatusCode::kInvalidArgument)
        << nothing;
  }
  EXPECT_EQ(*(*clip)->EncodeImage(*image), *first);
  EXPECT_EQ((*clip)->EncodeText("red apple")->values, text->values);
}

TEST(OpenCvClipTest, ThreadsGetTheSameVectors) {
  const auto clip = OpenCvClip::Open(TinyClip());
  ASSERT_TRUE(clip.ok()) << clip.status().message();
  const auto picture = [](int k) { return ImageU8(40 + k, 30, 3, 5 * k); };
  constexpr int kPictures = 24;
  std::vector<std::vector<float>> alone;
  for (int k = 0; k < kPictures; ++k) {
    const auto vector = (*clip)->EncodeImage(picture(k));
    ASSERT_TRUE(vector.ok()) << vector.status().message();
    alone.push_back(*vector);
  }
  std::vector<std::vector<float>> together(kPictures);
  ThreadPool pool(4);
  pool.ParallelFor(0, kPictures, 1, [&](int64_t first, int64_t last, int) {
    for (int64_t k = first; k < last; ++k) {
      const auto vector = (*clip)->EncodeImage(picture(static_cast<int>(k)));
      if (vector.ok()) together[k] = *vector;
    }
  });
  EXPECT_EQ(alone, together);
}

TEST(OpenCvClipTest, WhatIsAskedIsChecked) {
  const auto clip = OpenCvClip::Open(TinyClip());
  ASSERT_TRUE(clip.ok());
  for (const ImageU8& image : {ImageU8(), ImageU8(5, 5, 1), ImageU8(5, 5, 4)}) {
    EXPECT_EQ((*clip)->EncodeImage(image).status().code(),
              StatusCode::kInvalidArgument);
    EXPECT_EQ((*clip)->EncodeDense(image).status().code(),
              StatusCode::kInvalidArgument);
  }
  const Status no_size = (*clip)->EncodeDense(ImageU8(5, 5, 3), 224).status();
  EXPECT_EQ(no_size.code(), StatusCode::kInvalidArgument);
  for (const int size : (*clip)->dense_sizes()) {
    EXPECT_NE(no_size.message().find(std::to_string(size)), std::string::npos)
        << no_size.message();
  }
  EXPECT_EQ((*clip)->EncodeText(std::string(20000, 'x')).status().code(),
            StatusCode::kInvalidArgument);
}

TEST(OpenCvClipTest, AnyShapeOfImage) {
  const auto clip = OpenCvClip::Open(TinyClip());
  ASSERT_TRUE(clip.ok());
  for (const auto& [width, height] :
       {std::pair(1, 1), {1, 3000}, {3000, 1}, {17, 16}, {5, 2}}) {
    const ImageU8 image(width, height, 3, 90);
    EXPECT_TRUE((*clip)->EncodeImage(image).ok());
    EXPECT_TRUE((*clip)->EncodeDense(image).ok());
  }
}

TEST(OpenCvClipTest, UpsamplesWithTheModelsOwn) {
  const ModelCopy model;
  model.AddUpsampler();
  const auto clip = OpenCvClip::Open(model.path());
  ASSERT_TRUE(clip.ok()) << clip.status().message();
  ASSERT_EQ((*clip)->upsampled_size(), 16);
  ImageF features(2, 2, 8);
  for (size_t i = 0; i < features.size(); ++i) {
    features.data()[i] = static_cast<float>(i);
  }
  ImageU8 image(16, 16, 3, 51);
  image(9, 3, 1) = 255;
  const auto result = (*clip)->Upsample(features, image);
  ASSERT_TRUE(result.ok()) << result.status().message();
  ASSERT_EQ(result->width(), 16);
  ASSERT_EQ(result->channels(), 8);
  const ModelInfo& info = (*clip)->info();
  for (const auto& [x, y] : {std::pair(0, 0), {9, 3}, {3, 9}, {15, 15}}) {
    for (int c = 0; c < 8; ++c) {
      const float color = static_cast<float>(image(x, y, c % 3)) / 255;
      EXPECT_NEAR((*result)(x, y, c),
                  features(x / 8, y / 8, c) +
                      0.5f * (color - info.mean[c % 3]) / info.std[c % 3],
                  1e-4);
    }
  }
  EXPECT_EQ((*clip)->Upsample(ImageF(4, 4, 8), image).status().code(),
            StatusCode::kInvalidArgument);
  EXPECT_EQ((*clip)->Upsample(features, ImageU8()).status().code(),
            StatusCode::kInvalidArgument);
  const auto without = OpenCvClip::Open(TinyClip());
  ASSERT_TRUE(without.ok());
  EXPECT_EQ((*without)->upsampled_size(), 0);
  EXPECT_EQ((*without)->Upsample(features, image).status().code(),
            StatusCode::kInvalidArgument);
}

TEST(OpenCvClipTest, AnUpsamplerThatIsNone) {
  const ModelCopy model;
  model.AddUpsampler();
  model.Replace("upsampler.onnx", ReadText(TinyClip() / "text.onnx"));
  const auto clip = OpenCvClip::Open(model.path());
  ASSERT_TRUE(clip.ok()) << clip.status().message();
  const Status status =
      (*clip)->Upsample(ImageF(2, 2, 8), ImageU8(5, 5, 3)).status();
  EXPECT_EQ(status.code(), StatusCode::kMissingDependency);
  EXPECT_THAT(status.message(), HasSubstr("upsampler.onnx"));
  std::filesystem::remove(model.path() / "upsampler.onnx");
  EXPECT_EQ(OpenCvClip::Open(model.path()).status().code(),
            StatusCode::kMissingDependency);
}

// A network that is what model.json names, but not one that works.
TEST(OpenCvClipTest, BadNetworksAreNamedAndSilent) {
  const ImageU8 image(20, 20, 3, 100);
  const std::string visual = ReadText(TinyClip() / "visual.onnx");
  for (const std::string& content : {std::string(),
                                     std::string("not a network"),
                                     visual.substr(0, visual.size() / 2),
                                     ReadText(TinyClip() / "dense32.onnx"),
                                     ReadText(TinyClip() / "text.onnx")}) {
    const ModelCopy model;
    model.Replace("visual.onnx", content);
    const auto clip = OpenCvClip::Open(model.path());
    ASSERT_TRUE(clip.ok()) << clip.status().message();
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    const auto result = (*clip)->EncodeImage(image);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
    EXPECT_EQ(result.status().code(), StatusCode::kMissingDependency);
    EXPECT_THAT(result.status().message(), HasSubstr("visual.onnx"));
    // The other networks are not affected.
    EXPECT_TRUE((*clip)->EncodeDense(image).ok());
  }
}

// A field of an ONNX file (Protocol Buffers) of up to 127 bytes.
std::string Field(int number, const std::string& bytes) {
  return std::string{static_cast<char>(number << 3 | 2),
                     static_cast<char>(bytes.size())} +
         bytes;
}

std::string Field(int number, char value) {
  return {static_cast<char>(number << 3), value};
}

// A network whose one output is a constant of 2^45 numbers, more than an
// address space holds.
std::string HugeNetwork() {
  std::string sides;
  for (int i = 0; i < 3; ++i) sides += std::string("\0\x80\0\0\0\0\0\0", 8);
  const std::string shape =
      Field(1, 3) + Field(2, 7) + Field(8, "shape") + Field(9, sides);
  const std::string node = Field(1, "shape") + Field(2, "y") + Field(3, "n") +
                           Field(4, "ConstantOfShape");
  const std::string type = Field(1, Field(1, 1) + Field(2, ""));
  const std::string graph = Field(1, node) + Field(2, "g") + Field(5, shape) +
                            Field(12, Field(1, "y") + Field(2, type));
  return Field(1, 7) + Field(7, graph) + Field(8, Field(2, 13));
}

TEST(OpenCvClipTest, NoMemoryIsNoFaultOfTheModel) {
  const ModelCopy model;
  model.Replace("visual.onnx", HugeNetwork());
  const auto clip = OpenCvClip::Open(model.path());
  ASSERT_TRUE(clip.ok()) << clip.status().message();
  const auto result = (*clip)->EncodeImage(ImageU8(20, 20, 3, 100));
  EXPECT_EQ(result.status().code(), StatusCode::kInternal);
  EXPECT_THAT(result.status().message(), HasSubstr("out of memory"));
  EXPECT_TRUE((*clip)->EncodeDense(ImageU8(20, 20, 3, 100)).ok());
}

TEST(CenterSquareTest, CutsTheLongSide) {
  ImageU8 image(40, 20, 1);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 40; ++x) image(x, y) = static_cast<uint8_t>(6 * x);
  }
  const ImageU8 square = CenterSquare(image, 20);
  ASSERT_EQ(square.width(), 20);
  ASSERT_EQ(square.height(), 20);
  EXPECT_EQ(square(0, 0), 60);
  EXPECT_EQ(square(19, 19), 6 * 29);
  EXPECT_EQ(CenterSquare(ImageU8(3, 50, 1, 7), 6)(5, 5), 7);
}

}  // namespace
}  // namespace freegs::semantics
