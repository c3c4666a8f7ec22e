// SPDX-License-Identifier: BSD-3-Clause
// Round trips, foreign layouts, and damaged files.

#include "splat/scene/ply_io.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/files.h"
#include "tests/splat/random_model.h"
#include "tests/temporary_folder.h"

namespace freegs::splat {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr std::array<const char*, 14> kNames = {"x",
                                                "y",
                                                "z",
                                                "f_dc_0",
                                                "f_dc_1",
                                                "f_dc_2",
                                                "opacity",
                                                "scale_0",
                                                "scale_1",
                                                "scale_2",
                                                "rot_0",
                                                "rot_1",
                                                "rot_2",
                                                "rot_3"};

// A header with the properties of degree 0 as `type`.
std::string Header(const std::string& format,
                   const std::string& type,
                   const std::string& count) {
  std::string text =
      "ply\nformat " + format + " 1.0\nelement vertex " + count + "\n";
  for (const char* name : kNames) {
    text += "property " + type + " " + name + "\n";
  }
  return text + "end_header\n";
}

std::string MessageOf(const std::string& content) {
  const StatusOr<PlacedModel> model = ParsePly(content);
  EXPECT_FALSE(model.ok());
  if (model.ok()) return "";
  EXPECT_EQ(model.status().code(), StatusCode::kBadInput);
  return model.status().message();
}

class PlyDegreeTest : public ::testing::TestWithParam<int> {};

TEST_P(PlyDegreeTest, RoundTripKeepsEveryBit) {
  const GaussianModel model = RandomModel(37, GetParam(), 5, 3.0);
  const StatusOr<PlacedModel> read = ParsePly(SerializePly(model));
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_TRUE(SameParameters(model, read->model));
}

INSTANTIATE_TEST_SUITE_P(AllDegrees, PlyDegreeTest, ::testing::Range(0, 4));

TEST(PlyTest, FileRoundTripAndErrorsNameTheFile) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "ply_io_test_model.ply";
  const GaussianModel model = RandomModel(3, 1, 8);
  ASSERT_TRUE(WritePly(path, model).ok());
  const StatusOr<PlacedModel> read = ReadPly(path);
  ASSERT_TRUE(read.ok());
  EXPECT_TRUE(SameParameters(model, read->model));
  ASSERT_TRUE(WriteFileAtomic(path, "ply\n").ok());
  EXPECT_THAT(ReadPly(path).status().message(),
              HasSubstr("ply_io_test_model.ply"));
  std::filesystem::remove(path);
  EXPECT_FALSE(ReadPly(path).ok());
}

TEST(PlyTest, AntialiasedModelsSaySo) {
  GaussianModel model = RandomModel(3, 1, 4);
  EXPECT_EQ(SerializePly(model).find("SplatRenderMode"), std::string::npos);
  model.antialiased = true;
  std::string content = SerializePly(model);
  EXPECT_NE(content.find("\ncomment SplatRenderMode: mip\n"),
            std::string::npos);
  EXPECT_TRUE(ParsePly(content)->model.antialiased);
  content.replace(content.find("mip"), 3, "any");
  const auto other = ParsePly(content);
  ASSERT_TRUE(other.ok());
  EXPECT_FALSE(other->model.antialiased);
}

TEST(PlyTest, RotationsOfAnyLengthAreReadAsSuch) {
  GaussianModel model = RandomModel(3, 0, 4);
  const float rotations[] = {
      1e-11f, 0, 0, 0, 0, 3e20f, 0, 4e20f, 0.5f, -2, 0, 1};
  std::copy_n(rotations, 12, model.rotations.begin());
  const auto read = ParsePly(SerializePly(model));
  ASSERT_TRUE(read.ok());
  const float expected[] = {1, 0, 0, 0, 0, 0.6f, 0, 0.8f, 0.5f, -2, 0, 1};
  for (int k = 0; k < 12; ++k) {
    EXPECT_FLOAT_EQ(read->model.rotations[k], expected[k]) << k;
  }
}

TEST(PlyTest, EmptyModel) {
  const StatusOr<PlacedModel> read = ParsePly(SerializePly(GaussianModel()));
  ASSERT_TRUE(read.ok());
  EXPECT_TRUE(read->model.empty());
}

// The layout is shared with other programs: byte positions are fixed.
TEST(PlyTest, LayoutOfTheCommonFormat) {
  GaussianModel model = RandomModel(1, 1, 3);
  for (int k = 0; k < 9; ++k) model.sh_rest[k] = static_cast<float>(k);
  const std::string content = SerializePly(model);
  EXPECT_THAT(content, HasSubstr("property float nz\nproperty float f_dc_0\n"));
  EXPECT_THAT(content,
              HasSubstr("property float f_rest_8\nproperty float opacity\n"));
  std::array<float, 26> row;  // 3 + 3 + 3 + 9 + 1 + 3 + 4.
  std::memcpy(
      row.data(), content.data() + content.size() - sizeof(row), sizeof(row));
  EXPECT_EQ(row[0], model.means[0]);
  EXPECT_EQ(row[3], 0.0f);
  EXPECT_EQ(row[6], model.sh_dc[0]);
  // Channel-major: all of red first. Ours is [k][channel].
  EXPECT_EQ(row[9], 0.0f);
  EXPECT_EQ(row[10], 3.0f);
  EXPECT_EQ(row[11], 6.0f);
  EXPECT_EQ(row[12], 1.0f);
  EXPECT_EQ(row[18], model.opacity_logits[0]);
  EXPECT_EQ(row[19], model.log_scales[0]);
  EXPECT_EQ(row[22], model.rotations[0]);
}

TEST(PlyTest, AsciiInAnyOrderWithForeignPropertiesAndElements) {
  std::string text =
      "ply\r\nformat ascii 1.0\r\ncomment by hand\r\n"
      "element camera 1\nproperty list uchar int ids\nproperty double w\n"
      "element vertex 2\nproperty float quality\n";
  std::vector<std::string> reversed(kNames.rbegin(), kNames.rend());
  for (const std::string& name : reversed) {
    text += "property float " + name + "\n";
  }
  text +=
      "property list uchar float extra\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n"
      "3 7 8 9 0.5\n";
  // rot_3..0, scale_2..0, opacity, f_dc_2..0, z y x.
  text += "99 0.4 0.3 0.2 +0.1 -1 -2 -3 2.5 6 5 4 3 2 1e0 2 11 12\n";
  text += "99 0 0 0 0 -1 -2 -3 2.5 6 5 4 3 2 1e-400 0";
  text += "\n3 0 1 2\n";
  const StatusOr<PlacedModel> model = ParsePly(text);
  ASSERT_TRUE(model.ok()) << model.status().message();
  ASSERT_EQ(model->model.size(), 2u);
  EXPECT_EQ(model->model.sh_degree, 0);
  EXPECT_THAT(model->model.means, ::testing::ElementsAre(1, 2, 3, 0, 2, 3));
  EXPECT_THAT(model->model.sh_dc, ::testing::ElementsAre(4, 5, 6, 4, 5, 6));
  EXPECT_THAT(model->model.log_scales,
              ::testing::ElementsAre(-3, -2, -1, -3, -2, -1));
  EXPECT_THAT(
      model->model.rotations,
      ::testing::ElementsAre(0.1f, 0.2f, 0.3f, 0.4f, 1.0f, 0.0f, 0.0f, 0.0f));
}

TEST(PlyTest, BigEndianDoubles) {
  std::string content = Header("binary_big_endian", "double", "1");
  for (int p = 0; p < 14; ++p) {
    auto bytes = std::bit_cast<std::array<char, 8>>(p + 0.25);
    std::reverse(bytes.begin(), bytes.end());
    content.append(bytes.data(), bytes.size());
  }
  const StatusOr<PlacedModel> model = ParsePly(content);
  ASSERT_TRUE(model.ok()) << model.status().message();
  EXPECT_EQ(model->model.means[1], 1.25f);
  EXPECT_EQ(model->model.rotations[3], 13.25f);
}

TEST(PlyTest, BinaryListsAreSkippedByTheirLength) {
  std::string content =
      "ply\nformat binary_little_endian 1.0\nelement face 2\n"
      "property list uchar short v\n" +
      Header("x", "char", "1").substr(std::strlen("ply\nformat x 1.0\n"));
  content += std::string("\x02", 1) + std::string(4, '\0');
  content += std::string("\x00", 1);
  for (char p = 0; p < 14; ++p) content += p;
  const StatusOr<PlacedModel> model = ParsePly(content);
  ASSERT_TRUE(model.ok()) << model.status().message();
  EXPECT_EQ(model->model.opacity_logits[0], 6.0f);
}

TEST(PlyTest, NamesWhatIsMissing) {
  EXPECT_THAT(
      MessageOf("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                "property float y\nproperty float z\nend_header\n1 2 3\n"),
      AllOf(HasSubstr("f_dc_0"), HasSubstr("opacity"), HasSubstr("rot_3")));
  std::string with_rest = SerializePly(RandomModel(1, 1, 1));
  const size_t at = with_rest.find("f_rest_4");
  EXPECT_THAT(MessageOf(std::string(with_rest).replace(at, 8, "f_rest_9")),
              HasSubstr("f_rest_4"));
  EXPECT_THAT(MessageOf(std::string(with_rest).replace(at, 8, "g_rest_4")),
              HasSubstr("8 f_rest"));
}

// A Gaussian of one scale along all axes, with a 3D filter.
StatusOr<PlacedModel> ReadFiltered(const std::string& log_scale,
                                   const std::string& logit,
                                   const std::string& filter) {
  std::string text = Header("ascii", "float", "1");
  text.insert(text.find("end_header"), "property float filter_3D\n");
  return ParsePly(text + "1 2 3 0 0 0 " + logit + " " + log_scale + " " +
                  log_scale + " " + log_scale + " 1 0 0 0 " + filter + "\n");
}

TEST(PlyTest, TheFilterOfMipSplattingIsFused) {
  // A scale of 1e-4.
  auto read = ReadFiltered("-9.210340371976184", "2", "0.01");
  ASSERT_TRUE(read.ok()) << read.status().message();
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(std::exp(read->model.log_scales[k]), 0.0100005, 1e-8);
  }
  const float logit = read->model.opacity_logits[0];
  EXPECT_NEAR(1 / (1 + std::exp(-logit)), 8.806651e-7, 1e-12);

  // A filter of the Gaussian's own size.
  read = ReadFiltered("0", "0", "1");
  ASSERT_TRUE(read.ok());
  EXPECT_FLOAT_EQ(read->model.log_scales[1], std::log(2.0f) / 2);
  const double opacity = 0.5 * std::pow(0.5, 1.5);
  EXPECT_FLOAT_EQ(read->model.opacity_logits[0],
                  static_cast<float>(std::log(opacity / (1 - opacity))));

  read = ReadFiltered("-3", "2", "0");
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->model.log_scales[2], -3);
  EXPECT_EQ(read->model.opacity_logits[0], 2);
}

TEST(PlyTest, FusedNumbersStayFinite) {
  for (const char* const scale : {"-3e38", "-200", "0", "200", "3e38"}) {
    for (const char* const logit : {"-3e38", "-200", "0", "200", "3e38"}) {
      for (const char* const filter : {"1e-45", "1", "-1", "3e38"}) {
        const auto read = ReadFiltered(scale, logit, filter);
        ASSERT_TRUE(read.ok()) << read.status().message();
        EXPECT_TRUE(read->model.AllFinite())
            << scale << " " << logit << " " << filter;
        EXPECT_LE(read->model.opacity_logits[0], std::stof(logit));
      }
    }
  }
  EXPECT_THAT(ReadFiltered("0", "0", "nan").status().message(),
              HasSubstr("1 of 1 vertices"));
}

TEST(PlyTest, OfDegreeFourReadsTheLowerDegrees) {
  std::string text = Header("ascii", "float", "1");
  std::string names;
  std::string values = "1 2 3 0 0 0 0 -1 -1 -1 1 0 0 0";
  for (int k = 0; k < 72; ++k) {
    names += "property float f_rest_" + std::to_string(k) + "\n";
    values += " " + std::to_string(k);
  }
  text.insert(text.find("end_header"), names);
  const StatusOr<PlacedModel> read = ParsePly(text + values + "\n");
  ASSERT_TRUE(read.ok()) << read.status().message();
  ASSERT_EQ(read->model.sh_degree, 3);
  ASSERT_EQ(read->model.sh_rest.size(), 45u);
  for (int k = 0; k < 15; ++k) {
    for (int channel = 0; channel < 3; ++channel) {
      EXPECT_EQ(read->model.sh_rest[3 * k + channel], 24 * channel + k);
    }
  }
}

TEST(PlyTest, SaysThatAFileIsCompressed) {
  EXPECT_THAT(
      MessageOf("ply\nformat ascii 1.0\nelement chunk 1\n"
                "property float min_x\nelement vertex 1\n"
                "property uint packed_position\nproperty uint packed_rotation\n"
                "property uint packed_scale\nproperty uint packed_color\n"
                "end_header\n0\n1 2 3 4\n"),
      AllOf(HasSubstr("a compressed .ply"), HasSubstr("uncompressed")));
}

TEST(PlyTest, RefusesCountsThatTheContentCannotHold) {
  for (const char* count : {"18446744073709551615", "4000000000", "2"}) {
    EXPECT_THAT(MessageOf(Header("binary_little_endian", "float", count) +
                          std::string(56, '\0')),
                HasSubstr("at most 1"));
  }
  EXPECT_THAT(MessageOf(Header("ascii", "float", "1000000000") + "1 2 3"),
              HasSubstr("at most 0"));
  MessageOf(Header("ascii", "float", "-1"));
  MessageOf(Header("ascii", "float", "99999999999999999999999"));
  // A list longer than the file, and many empty items.
  MessageOf(
      "ply\nformat binary_little_endian 1.0\nelement a 18446744073709551615\n"
      "element b 18446744073709551615\nproperty list uint double v\n"
      "end_header\n\xff\xff\xff\xff");
}

TEST(PlyTest, RefusesTwoElementsOfOneName) {
  EXPECT_THAT(MessageOf("ply\nformat ascii 1.0\nelement vertex 1\n"
                        "property float x\nelement vertex 1\n"
                        "property float x\nend_header\n1\n2\n"),
              HasSubstr("two elements \"vertex\""));
}

TEST(PlyTest, RefusesManyElements) {
  std::string header = "ply\nformat ascii 1.0\n";
  for (int i = 0; i < 101; ++i) {
    header += "element e" + std::to_string(i) + " 0\n";
  }
  EXPECT_THAT(MessageOf(header + "end_header\n"),
              HasSubstr("more than 100 elements"));
}

TEST(PlyTest, CountsVerticesThatAreNotFinite) {
  GaussianModel model = RandomModel(10, 2, 1);
  model.means[4] = std::numeric_limits<float>::quiet_NaN();
  model.means[5] = std::numeric_limits<float>::infinity();
  model.sh_rest[24 * 7] = -std::numeric_limits<float>::infinity();
  EXPECT_THAT(MessageOf(SerializePly(model)), HasSubstr("2 of 10"));
  EXPECT_THAT(MessageOf(Header("ascii", "float", "1") +
                        "1e39 0 0 0 0 0 0 0 0 0 1 0 0 0\n"),
              HasSubstr("1 of 1"));
  EXPECT_THAT(MessageOf(Header("ascii", "float", "1") +
                        "1e999 0 0 0 0 0 0 0 0 0 1 0 0 0\n"),
              HasSubstr("1 of 1"));
}

TEST(PlyTest, EveryTruncationIsRefused) {
  const std::string content = SerializePly(RandomModel(2, 1, 6));
  for (size_t size = 0; size < content.size(); ++size) {
    MessageOf(content.substr(0, size));
  }
}

// Whatever a flipped byte does, it must not crash or hang.
TEST(PlyTest, SurvivesMutations) {
  std::string ascii = Header("ascii", "float", "1");
  ascii += "0 0 0 0 0 0 0 0 0 0 1 0 0 0\n";
  const std::array<std::string, 2> contents = {
      SerializePly(RandomModel(2, 0, 6)), ascii};
  for (const std::string& content : contents) {
    for (size_t at = 0; at < content.size(); ++at) {
      for (const char c : {'\0', '\n', ' ', '9', '-', 'x', '\xff'}) {
        std::string mutated = content;
        mutated[at] = c;
        const StatusOr<PlacedModel> model = ParsePly(mutated);
        if (model.ok()) {
          EXPECT_TRUE(model->model.AllFinite());
        }
      }
    }
  }
}

}  // namespace
}  // namespace freegs::splat
