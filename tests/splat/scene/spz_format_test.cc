// SPDX-License-Identifier: BSD-3-Clause

#include "splat/scene/spz_format.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/byte_stream.h"
#include "core/io/gzip.h"
#include "tests/splat/random_model.h"
#include "tests/temporary_folder.h"

namespace freegs::splat {
namespace {

using testing::HasSubstr;

constexpr uint64_t kMaxBytes = 1 << 24;

std::string Unpacked(const GaussianModel& model,
                     const SpzOptions& options = {}) {
  return Gunzip(SerializeSpz(model, options).value(), kMaxBytes).value();
}

std::string Packed(std::string_view content) { return Gzip(content).value(); }

Status ParseUnpacked(std::string_view content) {
  return ParseSpz(Packed(content)).status();
}

int SpzByteAt(const std::string& content, size_t at) {
  return static_cast<unsigned char>(content[at]);
}

Eigen::Quaterniond Rotation(const GaussianModel& model, size_t i) {
  const float* const q = &model.rotations[4 * i];
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
}

// One Gaussian at (1, -2, 3), turned by a quarter about y.
GaussianModel OneGaussian() {
  GaussianModel model;
  model.sh_degree = 1;
  model.Resize(1);
  model.means = {1, -2, 3};
  model.log_scales = {-10, 0, 20};
  model.rotations = {3, 0, 3, 0};
  model.opacity_logits = {0};
  model.sh_dc = {0, 100, -100};
  model.sh_rest = {0.5, 0, -0.5, 0.25, 0, 0, 2, -2, 0};
  return model;
}

TEST(SpzFormatTest, BytesLieWhereTheFormatSays) {
  GaussianModel model = OneGaussian();
  model.antialiased = true;
  const std::string content = Unpacked(model, {.flip_axes = false});
  ASSERT_EQ(content.size(), 16u + 9 + 1 + 3 + 3 + 4 + 9);
  EXPECT_EQ(content.substr(0, 4), "NGSP");
  EXPECT_EQ(SpzByteAt(content, 4), 3);   // Version.
  EXPECT_EQ(SpzByteAt(content, 8), 1);   // Gaussians.
  EXPECT_EQ(SpzByteAt(content, 12), 1);  // SH degree.
  EXPECT_EQ(SpzByteAt(content, 14), 1);  // Antialiased.
  const int bits = SpzByteAt(content, 13);
  EXPECT_EQ(bits, 15);
  const int x = SpzByteAt(content, 16) | SpzByteAt(content, 17) << 8 |
                SpzByteAt(content, 18) << 16;
  EXPECT_EQ(x, 1 << bits);
  const int y = SpzByteAt(content, 19) | SpzByteAt(content, 20) << 8 |
                SpzByteAt(content, 21) << 16;
  EXPECT_EQ(y, (1 << 24) - (2 << bits));
  EXPECT_EQ(SpzByteAt(content, 25), 128);  // Opacity.
  EXPECT_EQ(SpzByteAt(content, 26), 128);  // Colour.
  EXPECT_EQ(SpzByteAt(content, 27), 255);
  EXPECT_EQ(SpzByteAt(content, 28), 0);
  EXPECT_EQ(SpzByteAt(content, 29), 0);  // Scales.
  EXPECT_EQ(SpzByteAt(content, 30), 160);
  EXPECT_EQ(SpzByteAt(content, 31), 255);
  // y and w are the same; y is the first of them. Then x, z and w follow, w
  // with the largest number there is.
  uint32_t rotation = 0;
  for (int k = 3; k >= 0; --k) {
    rotation =
        rotation << 8 | static_cast<uint32_t>(SpzByteAt(content, 32 + k));
  }
  EXPECT_EQ(rotation, uint32_t{1} << 30 | 511);
  EXPECT_EQ(SpzByteAt(content, 36), 192);  // Harmonics.
  EXPECT_EQ(SpzByteAt(content, 37), 128);
  EXPECT_EQ(SpzByteAt(content, 38), 64);
  EXPECT_EQ(SpzByteAt(content, 39), 160);
  EXPECT_EQ(SpzByteAt(content, 42), 255);
  EXPECT_EQ(SpzByteAt(content, 43), 0);
}

TEST(SpzFormatTest, RoundTripIsWithinAStep) {
  for (int degree = 0; degree <= kMaxShDegree; ++degree) {
    for (const bool flip : {true, false}) {
      GaussianModel model = RandomModel(300, degree, 7);
      model.antialiased = flip;
      const auto read =
          ParseSpz(SerializeSpz(model, {.flip_axes = flip}).value(), flip);
      ASSERT_TRUE(read.ok()) << read.status().message();
      ASSERT_EQ(read->size(), model.size());
      EXPECT_EQ(read->sh_degree, degree);
      EXPECT_EQ(read->antialiased, flip);
      for (size_t i = 0; i < model.means.size(); ++i) {
        EXPECT_NEAR(read->means[i], model.means[i], 1e-5);
        EXPECT_NEAR(read->log_scales[i], model.log_scales[i], 0.5 / 16 + 1e-5);
        EXPECT_NEAR(read->sh_dc[i], model.sh_dc[i], 0.5 / 255 / 0.15 + 1e-5);
      }
      for (size_t i = 0; i < model.size(); ++i) {
        EXPECT_NEAR(read->opacity_logits[i], model.opacity_logits[i], 0.011);
        EXPECT_LT(Rotation(*read, i).angularDistance(Rotation(model, i)), 4e-3);
      }
      for (size_t i = 0; i < model.sh_rest.size(); ++i) {
        const size_t coefficient = i % model.sh_rest_stride() / 3;
        const double half_step = coefficient < 3 ? 4 : 8;
        // The highest step would be 256, which no byte holds.
        EXPECT_NEAR(read->sh_rest[i], model.sh_rest[i], (half_step + 1) / 128);
      }
    }
  }
}

// The colour that a viewer sees must turn with the scene: the basis functions
// up to degree 3 change their signs as x, y, z do.
TEST(SpzFormatTest, FlipTurnsTheWholeScene) {
  GaussianModel model = RandomModel(20, 3, 3);
  model.means.assign(model.means.size(), 0);
  model.means[0] = 1;
  model.means[1] = 2;
  model.means[2] = 3;
  const auto turned = ParseSpz(SerializeSpz(model).value(), false);
  const auto plain =
      ParseSpz(SerializeSpz(model, {.flip_axes = false}).value(), false);
  ASSERT_TRUE(turned.ok() && plain.ok());
  EXPECT_EQ(turned->means[0], 1);
  EXPECT_EQ(turned->means[1], -2);
  EXPECT_EQ(turned->means[2], -3);
  const Eigen::Matrix3d turn = Eigen::Vector3d(1, -1, -1).asDiagonal();
  for (size_t i = 0; i < model.size(); ++i) {
    const Eigen::Matrix3d a = Rotation(*turned, i).toRotationMatrix();
    const Eigen::Matrix3d b = Rotation(model, i).toRotationMatrix();
    EXPECT_LT((a - turn * b * turn).norm(), 0.01);
  }
  const auto basis = [](double x, double y, double z) {
    return std::array<double, 15>{y,
                                  z,
                                  x,
                                  x * y,
                                  y * z,
                                  3 * z * z - 1,
                                  x * z,
                                  x * x - y * y,
                                  y * (3 * x * x - y * y),
                                  x * y * z,
                                  y * (5 * z * z - 1),
                                  z * (5 * z * z - 3),
                                  x * (5 * z * z - 1),
                                  z * (x * x - y * y),
                                  x * (x * x - 3 * y * y)};
  };
  const auto before = basis(0.48, 0.6, 0.64);
  const auto after = basis(0.48, -0.6, -0.64);
  for (size_t k = 0; k < 15; ++k) {
    EXPECT_NEAR(turned->sh_rest[3 * k] * after[k],
                plain->sh_rest[3 * k] * before[k],
                17.0 / 128);
  }
}

TEST(SpzFormatTest, LowerDegree) {
  const GaussianModel model = RandomModel(10, 3, 5);
  const auto read = ParseSpz(SerializeSpz(model, {.sh_degree = 1}).value());
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->sh_degree, 1);
  EXPECT_NEAR(read->sh_rest[9], model.sh_rest[45], 0.05);
}

TEST(SpzFormatTest, ReadsDegreeFour) {
  GaussianModel model;
  model.sh_degree = 1;
  model.Resize(1);
  std::string content = Unpacked(model);
  content[12] = 4;
  content.append(3 * (24 - 3), '\x40');
  const auto read = ParseSpz(Packed(content));
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->sh_degree, 3);
  EXPECT_EQ(read->sh_rest[0], 0);
  EXPECT_EQ(std::abs(read->sh_rest[44]), 0.5f);
}

TEST(SpzFormatTest, ReadsVersionTwo) {
  GaussianModel model;
  model.Resize(2);
  std::string content = Unpacked(model);
  content[4] = 2;
  content.resize(content.size() - 8);
  // x = 0.6 and w = 0.8; then z = -1.
  for (const int byte : {204, 128, 128, 128, 128, 0}) {
    content.push_back(static_cast<char>(byte));
  }
  const auto read = ParseSpz(Packed(content), false);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_NEAR(read->rotations[0], 0.8, 0.01);
  EXPECT_NEAR(read->rotations[1], 0.6, 0.01);
  EXPECT_NEAR(read->rotations[7], -1, 0.01);
}

TEST(SpzFormatTest, OpacityStaysFinite) {
  GaussianModel model;
  model.Resize(2);
  model.opacity_logits = {-50, 50};
  const auto read = ParseSpz(SerializeSpz(model).value());
  ASSERT_TRUE(read.ok());
  EXPECT_TRUE(read->AllFinite());
  EXPECT_LT(read->opacity_logits[0], -6);
  EXPECT_GT(read->opacity_logits[1], 6);
}

TEST(SpzFormatTest, FarAndNearPositions) {
  GaussianModel model;
  model.Resize(3);
  for (const float size : {1e-4f, 1e-2f, 1.0f, 100.0f, 3000.0f, 8e6f}) {
    model.means = {size, -size, 0, size / 3, 0, 0, 0, -size / 7, size};
    const auto read = ParseSpz(SerializeSpz(model).value());
    ASSERT_TRUE(read.ok());
    for (size_t i = 0; i < 9; ++i) {
      EXPECT_NEAR(read->means[i],
                  model.means[i],
                  std::max(0.51 * std::ldexp(1.0, -23), 8e-6 * size));
    }
  }
  // One that is far away makes the steps of all larger.
  model.means = {1, 1, 1, 2, 2, 2, 1e6f, 0, 0};
  const auto read = ParseSpz(SerializeSpz(model).value());
  ASSERT_TRUE(read.ok());
  EXPECT_NEAR(read->means[6], 1e6, 1);
  EXPECT_NEAR(read->means[3], 2, 0.2);
}

// The least number of 24 bits, without any for a fraction, is farther from zero
// than any position that can be written.
TEST(SpzFormatTest, WhatWasReadCanBeWritten) {
  std::string content = Unpacked(OneGaussian(), {.flip_axes = false});
  content[13] = 0;
  content.replace(16, 3, std::string("\0\0\x80", 3));
  const auto read = ParseSpz(Gzip(content).value(), false);
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->means[0], -8388607.0f);
  EXPECT_TRUE(SerializeSpz(*read).ok());
}

TEST(SpzFormatTest, RefusesWhatItCannotHold) {
  GaussianModel model;
  model.Resize(1);
  model.means[0] = 1e7f;
  EXPECT_THAT(SerializeSpz(model).status().message(), HasSubstr("too far"));
  model.means[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(SerializeSpz(model).status().code(), StatusCode::kBadInput);
}

TEST(SpzFormatTest, EmptyModel) {
  const auto read = ParseSpz(SerializeSpz(GaussianModel()).value());
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_TRUE(read->empty());
}

TEST(SpzFormatTest, SameBytes) {
  const GaussianModel model = RandomModel(100, 2, 1);
  EXPECT_EQ(SerializeSpz(model).value(), SerializeSpz(model).value());
}

TEST(SpzFormatTest, ReadsTheFileThatWasWritten) {
  const TemporaryFolder folder;
  const GaussianModel model = RandomModel(10, 0, 1);
  ASSERT_TRUE(WriteSpz(folder / "a.spz", model).ok());
  EXPECT_EQ(ReadSpz(folder / "a.spz").value().size(), 10u);
}

TEST(SpzFormatTest, ErrorsNameTheFile) {
  const TemporaryFolder folder;
  WriteText(folder / "b.spz", "ply");
  EXPECT_THAT(ReadSpz(folder / "b.spz").status().message(), HasSubstr("b.spz"));
}

// A scene in other units: the format's sizes are in those of the world.
TEST(SpzFormatTest, FilesHaveTheSizesOfTheModel) {
  const TemporaryFolder folder;
  GaussianModel model = RandomModel(2000, 0, 1);
  for (size_t i = 0; i < model.log_scales.size(); ++i) {
    // Flat ones, whose thin side is below what the format can say.
    model.log_scales[i] = i % 3 == 0 ? -12.0f : -3.0f;
  }
  const auto write = [&](double unit, size_t count) {
    GaussianModel scaled = model;
    for (size_t i = 0; i < 3 * count; ++i) {
      scaled.log_scales[i] += static_cast<float>(std::log(unit));
    }
    return WriteSpz(folder / "a.spz", scaled);
  };
  EXPECT_TRUE(write(1, 2000).ok());
  for (const double unit : {1e-3, 1e4}) {
    const Status status = write(unit, 2000);
    EXPECT_EQ(status.code(), StatusCode::kBadInput);
    EXPECT_THAT(status.message(), HasSubstr("a.spz: 2000 of 2000"));
    EXPECT_THAT(status.message(), HasSubstr("take .ply"));
    EXPECT_TRUE(write(unit, 2).ok());
    EXPECT_FALSE(write(unit, 3).ok());
  }
  // One is allowed even among few.
  model.Resize(10);
  EXPECT_TRUE(write(1e4, 1).ok());
  EXPECT_FALSE(write(1e4, 2).ok());
  model.Resize(2000);
  // What nobody sees does not count.
  model.opacity_logits.assign(2000, -4);
  EXPECT_TRUE(write(1e4, 2000).ok());
}

TEST(SpzFormatTest, RefusesTruncation) {
  const std::string packed = SerializeSpz(RandomModel(3, 1, 1)).value();
  for (size_t size = 0; size < packed.size(); ++size) {
    EXPECT_EQ(ParseSpz(packed.substr(0, size)).status().code(),
              StatusCode::kBadInput);
  }
  const std::string content = Unpacked(RandomModel(3, 1, 1));
  for (size_t size = 0; size < content.size(); ++size) {
    EXPECT_EQ(ParseUnpacked(content.substr(0, size)).code(),
              StatusCode::kBadInput);
  }
  EXPECT_EQ(ParseUnpacked(content + "x").code(), StatusCode::kBadInput);
}

TEST(SpzFormatTest, RefusesHostileHeaders) {
  const std::string good = Unpacked(RandomModel(3, 1, 1));
  const auto with = [&](size_t at, std::initializer_list<int> bytes) {
    std::string content = good;
    for (const int byte : bytes) content[at++] = static_cast<char>(byte);
    return ParseUnpacked(content);
  };
  EXPECT_TRUE(with(0, {'N'}).ok());
  EXPECT_THAT(with(0, {'X'}).message(), HasSubstr("NGSP"));
  EXPECT_THAT(with(4, {1}).message(), HasSubstr("version 1"));
  EXPECT_THAT(with(4, {4}).message(), HasSubstr("version 4"));
  EXPECT_THAT(with(8, {255, 255, 255, 255}).message(),
              HasSubstr("4294967295 Gaussians"));
  EXPECT_THAT(with(8, {0, 0x96, 0x98, 0}).message(), HasSubstr("promises"));
  EXPECT_THAT(with(8, {4}).message(), HasSubstr("promises 4"));
  EXPECT_FALSE(with(8, {2}).ok());
  EXPECT_THAT(with(12, {5}).message(), HasSubstr("degree 5"));
  EXPECT_FALSE(with(12, {3}).ok());
  EXPECT_THAT(with(13, {24}).message(), HasSubstr("24 fractional bits"));
  EXPECT_THAT(ParseSpz("NGSP and more").status().message(),
              HasSubstr("version 4"));
}

std::string ExtensionRecord(uint32_t type, uint32_t length, uint32_t value) {
  ByteWriter writer;
  writer.Put(type);
  writer.Put(length);
  writer.Put(value);
  return std::move(writer).content();
}

constexpr uint32_t kFrameRecord = 0xADBE0003;

TEST(SpzFormatTest, ReadsTheFrameThatAnExtensionNames) {
  // Left or right, down or up, back or front, in this order; ours is right,
  // down, front.
  const std::array<Eigen::Vector3d, 9> signs = {{{1, -1, -1},  // Unspecified.
                                                 {-1, 1, -1},
                                                 {1, 1, -1},
                                                 {-1, -1, -1},
                                                 {1, -1, -1},
                                                 {-1, 1, 1},
                                                 {1, 1, 1},
                                                 {-1, -1, 1},
                                                 {1, -1, 1}}};
  const GaussianModel model = RandomModel(6, 3, 3);
  std::string content = Unpacked(model, {.flip_axes = false});
  content[14] = 2;
  const auto stored = ParseSpz(Packed(content), false);
  ASSERT_TRUE(stored.ok());
  for (uint32_t frame = 0; frame < signs.size(); ++frame) {
    const Eigen::Matrix3d flip = signs[frame].asDiagonal();
    const auto read = ParseSpz(Packed(content + ExtensionRecord(7, 4, 0) +
                                      ExtensionRecord(kFrameRecord, 4, frame)));
    ASSERT_TRUE(read.ok()) << read.status().message();
    for (size_t i = 0; i < model.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        EXPECT_EQ(read->means[3 * i + k],
                  stored->means[3 * i + k] * signs[frame][k]);
      }
      const Eigen::Matrix3d turned = Rotation(*read, i).toRotationMatrix();
      const Eigen::Matrix3d before = Rotation(*stored, i).toRotationMatrix();
      EXPECT_LT((turned - flip * before * flip).norm(), 1e-5) << frame;
      for (const auto& [k, axes] : {std::pair{0, "y"},
                                    {1, "z"},
                                    {2, "x"},
                                    {3, "xy"},
                                    {6, "xz"},
                                    {7, ""},
                                    {9, "xyz"},
                                    {14, "x"}}) {
        double sign = 1;
        for (const char axis : std::string(axes)) {
          sign *= signs[frame][axis - 'x'];
        }
        EXPECT_EQ(read->sh_rest[45 * i + 3 * k],
                  stored->sh_rest[45 * i + 3 * k] * sign)
            << frame << " " << axes;
      }
    }
  }
}

TEST(SpzFormatTest, RefusesFramesThatItCannotRead) {
  std::string content = Unpacked(RandomModel(3, 1, 1));
  const std::string other = ExtensionRecord(kFrameRecord, 4, 12);
  EXPECT_TRUE(ParseUnpacked(content).ok());
  content[14] = 2;
  EXPECT_THAT(ParseUnpacked(content + other).message(),
              HasSubstr("coordinate system 12"));
  for (const uint32_t length : {0u, 3u, 5u, 0xffffffffu}) {
    EXPECT_THAT(
        ParseUnpacked(content + ExtensionRecord(kFrameRecord, length, 6))
            .message(),
        HasSubstr("damaged"))
        << length;
  }
  EXPECT_THAT(ParseUnpacked(content + other.substr(0, 9)).message(),
              HasSubstr("damaged"));
  // What is not whole, or hidden by it, is no record of a frame.
  EXPECT_TRUE(ParseUnpacked(content + other.substr(0, 7)).ok());
  EXPECT_TRUE(
      ParseUnpacked(content + ExtensionRecord(7, 0xffffffff, 1) + other).ok());
  EXPECT_TRUE(ParseUnpacked(content + ExtensionRecord(7, 16, 1) + other).ok());
}

// Records of other programs may follow, but not without end.
TEST(SpzFormatTest, SkipsExtensions) {
  std::string content = Unpacked(RandomModel(3, 1, 1));
  content[14] = 2;
  EXPECT_TRUE(ParseUnpacked(content + "any records").ok());
  EXPECT_FALSE(ParseUnpacked(content + std::string(2 << 20, 'x')).ok());
}

}  // namespace
}  // namespace freegs::splat
