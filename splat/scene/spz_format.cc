// SPDX-License-Identifier: BSD-3-Clause

#include "splat/scene/spz_format.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "core/io/byte_stream.h"
#include "core/io/files.h"
#include "core/io/gzip.h"
#include "splat/scene/spz_frame.h"

namespace freegs::splat {
namespace {

constexpr std::string_view kMagic = "NGSP";
constexpr uint32_t kVersion = 3;
constexpr uint32_t kOldestVersion = 2;
constexpr size_t kHeaderBytes = 16;
constexpr uint8_t kAntialiasedFlag = 1;
constexpr uint8_t kExtensionsFlag = 2;
constexpr uint64_t kMaxExtensionBytes = 1 << 20;

constexpr int kMaxFixed = (1 << 23) - 1;
constexpr int kMaxFractionalBits = 23;
constexpr int kUsualFractionalBits = 12;
constexpr double kStepsOfMedian = 65536;
constexpr double kColorScale = 0.15;
constexpr double kScaleSteps = 16;
constexpr double kMinLogScale = -10;
static_assert(kMaxSpzLogScale == kMinLogScale + 255 / kScaleSteps);
constexpr int kRotationMax = 511;  // 9 bits and a sign.

// Gaussians of less opacity are hardly seen.
constexpr double kSeenOpacity = 0.05;
// The largest share of Gaussians with sizes that the format cannot say. Trained
// scenes of a few world units have none. Where it was three in a thousand, the
// background was lost.
constexpr double kMaxMisfitShare = 0.001;

struct SpzHeader {
  uint32_t version = kVersion;
  uint32_t count = 0;
  uint8_t sh_degree = 0;
  uint8_t fractional_bits = 0;
  uint8_t flags = 0;
  uint8_t reserved = 0;

  size_t rotation_bytes() const { return version == 2 ? 3 : 4; }
  size_t sh_bytes() const { return 3 * (NumShCoefficients(sh_degree) - 1); }
  uint64_t content_bytes() const {
    return kHeaderBytes +
           uint64_t{count} * (9 + 1 + 3 + 3 + rotation_bytes() + sh_bytes());
  }
};

uint8_t ToSpzByte(double value) {
  return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

// The most bits with which the farthest Gaussian still fits, but not more than
// are useful: idle bits make the file larger.
StatusOr<int> FractionalBits(const GaussianModel& model) {
  if (model.empty()) return kUsualFractionalBits;
  std::vector<float> distances(model.size());
  for (size_t i = 0; i < model.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      distances[i] = std::max(distances[i], std::abs(model.means[3 * i + k]));
    }
  }
  const double farthest = *std::max_element(distances.begin(), distances.end());
  const auto middle = distances.begin() + distances.size() / 2;
  std::nth_element(distances.begin(), middle, distances.end());
  int bits = kUsualFractionalBits;
  while (bits < kMaxFractionalBits &&
         *middle * std::ldexp(1.0, bits) < kStepsOfMedian) {
    ++bits;
  }
  while (bits >= 0 && farthest * std::ldexp(1.0, bits) > kMaxFixed) --bits;
  if (bits < 0) {
    return BadInputError(
        "a Gaussian lies too far from the origin for the .spz format, which "
        "holds coordinates below 8388608");
  }
  return bits;
}

// Whether the file would show a Gaussian in about its size. A flat one may have
// a thin side below the format's least size, if that side grows to no more than
// a tenth of the largest.
bool SizeFits(const float* log_scales) {
  const auto [least, largest] = std::minmax_element(log_scales, log_scales + 3);
  return *largest <= kMaxSpzLogScale &&
         (*least >= kMinLogScale ||
          *largest >= kMinLogScale + std::numbers::ln10);
}

Status CheckSpzSizes(const GaussianModel& model) {
  const double seen_logit = std::log(kSeenOpacity / (1 - kSeenOpacity));
  size_t seen = 0;
  size_t misfits = 0;
  for (size_t i = 0; i < model.size(); ++i) {
    if (model.opacity_logits[i] < seen_logit) continue;
    ++seen;
    if (!SizeFits(&model.log_scales[3 * i])) ++misfits;
  }
  // An object of a few Gaussians may have one, as the whole scene may.
  if (static_cast<double>(misfits) <=
      std::max(1.0, kMaxMisfitShare * static_cast<double>(seen))) {
    return Status();
  }
  return BadInputError(
      std::to_string(misfits) + " of " + std::to_string(seen) +
      " Gaussians have sizes that the .spz format cannot say, which are "
      "standard deviations of 4.5e-5 to 379 world units; take .ply, whose "
      "units are free");
}

void PutPosition(const float* mean,
                 double steps,
                 const AxisSigns& signs,
                 ByteWriter* writer) {
  for (int k = 0; k < 3; ++k) {
    const double value = steps * mean[k] * signs.position[k];
    const auto bits = static_cast<uint32_t>(std::lround(value));
    for (int shift = 0; shift < 24; shift += 8) {
      writer->Put(static_cast<uint8_t>(bits >> shift));
    }
  }
}

// The quaternion x y z w of unit length, in the file's frame.
std::array<double, 4> FileRotation(const float* wxyz, const AxisSigns& signs) {
  std::array<double, 4> q = {wxyz[1], wxyz[2], wxyz[3], wxyz[0]};
  double norm = 0;
  for (const double c : q) norm += c * c;
  if (norm == 0) return {0, 0, 0, 1};
  for (double& c : q) c /= std::sqrt(norm);
  for (int k = 0; k < 3; ++k) q[k] *= signs.rotation[k];
  return q;
}

// None of the smaller numbers of a unit quaternion exceeds the square root of
// one half, which therefore is the largest that 9 bits say.
uint32_t PackRotation(const std::array<double, 4>& q) {
  uint32_t largest = 0;
  for (uint32_t k = 1; k < 4; ++k) {
    if (std::abs(q[k]) > std::abs(q[largest])) largest = k;
  }
  uint32_t packed = largest;
  for (uint32_t k = 0; k < 4; ++k) {
    if (k == largest) continue;
    const auto size = static_cast<uint32_t>(std::min<int64_t>(
        std::lround(std::abs(q[k]) * std::numbers::sqrt2 * kRotationMax),
        kRotationMax));
    // q and -q are the same rotation: the largest number is made positive.
    const uint32_t negative = (q[k] < 0) != (q[largest] < 0) ? 1 : 0;
    packed = packed << 10 | negative << 9 | size;
  }
  return packed;
}

std::array<double, 4> UnpackRotation(uint32_t packed) {
  const uint32_t largest = packed >> 30;
  std::array<double, 4> q{};
  double rest = 1;
  for (int k = 3; k >= 0; --k) {
    if (static_cast<uint32_t>(k) == largest) continue;
    q[k] = (packed & 511) / (std::numbers::sqrt2 * kRotationMax);
    if ((packed >> 9 & 1) != 0) q[k] = -q[k];
    rest -= q[k] * q[k];
    packed >>= 10;
  }
  q[largest] = std::sqrt(std::max(rest, 0.0));
  return q;
}

std::array<double, 4> UnpackOldRotation(const uint8_t* xyz) {
  std::array<double, 4> q{};
  double rest = 1;
  for (int k = 0; k < 3; ++k) {
    q[k] = xyz[k] / 127.5 - 1;
    rest -= q[k] * q[k];
  }
  q[3] = std::sqrt(std::max(rest, 0.0));
  return q;
}

uint8_t ShByte(double value, int coefficient) {
  const double step = coefficient < 3 ? 8 : 16;
  return ToSpzByte(step * std::round(128 * (value + 1) / step));
}

StatusOr<SpzHeader> ParseSpzHeader(std::string_view beginning,
                                   size_t packed_bytes) {
  SpzHeader header;
  ByteReader reader(beginning);
  if (!reader.SkipBytes(kMagic)) {
    return BadInputError("no .spz file: its content does not begin with NGSP");
  }
  if (!reader.Get(&header.version) || !reader.Get(&header.count) ||
      !reader.Get(&header.sh_degree) || !reader.Get(&header.fractional_bits) ||
      !reader.Get(&header.flags) || !reader.Get(&header.reserved)) {
    return BadInputError("the header is truncated");
  }
  if (header.version < kOldestVersion || header.version > kVersion) {
    return BadInputError(".spz version " + std::to_string(header.version) +
                         " is not supported; 2 and 3 are");
  }
  if (header.sh_degree > kMaxFileShDegree) {
    return BadInputError("SH degree " + std::to_string(header.sh_degree) +
                         " does not exist in .spz files");
  }
  if (header.fractional_bits > kMaxFractionalBits) {
    return BadInputError(std::to_string(header.fractional_bits) +
                         " fractional bits do not fit into 24");
  }
  // Deflate packs at most 1032 bytes into one.
  if (header.count > kMaxSpzGaussians ||
      header.content_bytes() / 1032 > packed_bytes) {
    return BadInputError(
        "the header promises " + std::to_string(header.count) +
        " Gaussians, more than the file or the format can hold");
  }
  return header;
}

// The header of a file of `packed_bytes` that begins with `bytes`.
StatusOr<SpzHeader> UnpackHeader(std::string_view bytes, size_t packed_bytes) {
  if (bytes.starts_with(kMagic)) {
    return BadInputError(
        ".spz version 4 is not supported; 2 and 3, packed by gzip, are");
  }
  if (!IsGzip(bytes)) {
    return BadInputError("no .spz file: it does not begin like gzip data");
  }
  FREEGS_ASSIGN_OR_RETURN(const std::string beginning,
                          GunzipBeginning(bytes, kHeaderBytes));
  return ParseSpzHeader(beginning, packed_bytes);
}

// Takes the arrays off a content that is as long as the header says.
class SpzArrays {
 public:
  explicit SpzArrays(std::string_view content)
      : at_(reinterpret_cast<const uint8_t*>(content.data()) + kHeaderBytes) {}

  const uint8_t* Take(size_t num_bytes) {
    const uint8_t* const begin = at_;
    at_ += num_bytes;
    return begin;
  }

 private:
  const uint8_t* at_;
};

// Keeps an opacity of 0 or 1 finite as a logit.
float OpacityLogit(uint8_t alpha) {
  const double opacity = std::clamp<double>(alpha, 0.25, 255 - 0.25) / 255.0;
  return static_cast<float>(std::log(opacity / (1 - opacity)));
}

GaussianModel Decode(const SpzHeader& header,
                     std::string_view content,
                     const AxisSigns& signs) {
  const size_t count = header.count;
  GaussianModel model;
  model.sh_degree = std::min<int>(header.sh_degree, kMaxShDegree);
  model.antialiased = (header.flags & kAntialiasedFlag) != 0;
  model.Resize(count);
  SpzArrays arrays(content);

  const uint8_t* const positions = arrays.Take(9 * count);
  const double step = std::ldexp(1.0, -header.fractional_bits);
  for (size_t i = 0; i < 3 * count; ++i) {
    const uint8_t* const p = positions + 3 * i;
    // The highest byte goes to the top, so that the sign is carried down. The
    // least number has no counterpart above zero, and is not written.
    const int32_t fixed = std::max(
        static_cast<int32_t>(uint32_t{p[0]} << 8 | uint32_t{p[1]} << 16 |
                             uint32_t{p[2]} << 24) /
            256,
        -kMaxFixed);
    model.means[i] = static_cast<float>(step * fixed * signs.position[i % 3]);
  }
  const uint8_t* const alphas = arrays.Take(count);
  for (size_t i = 0; i < count; ++i) {
    model.opacity_logits[i] = OpacityLogit(alphas[i]);
  }
  const uint8_t* const colors = arrays.Take(3 * count);
  for (size_t i = 0; i < 3 * count; ++i) {
    model.sh_dc[i] =
        static_cast<float>((colors[i] / 255.0 - 0.5) / kColorScale);
  }
  const uint8_t* const scales = arrays.Take(3 * count);
  for (size_t i = 0; i < 3 * count; ++i) {
    model.log_scales[i] =
        static_cast<float>(scales[i] / kScaleSteps + kMinLogScale);
  }
  const size_t rotation_bytes = header.rotation_bytes();
  const uint8_t* const rotations = arrays.Take(rotation_bytes * count);
  for (size_t i = 0; i < count; ++i) {
    const uint8_t* const r = rotations + rotation_bytes * i;
    const std::array<double, 4> q =
        header.version == 2
            ? UnpackOldRotation(r)
            : UnpackRotation(uint32_t{r[0]} | uint32_t{r[1]} << 8 |
                             uint32_t{r[2]} << 16 | uint32_t{r[3]} << 24);
    model.rotations[4 * i] = static_cast<float>(q[3]);
    for (int k = 0; k < 3; ++k) {
      model.rotations[4 * i + 1 + k] =
          static_cast<float>(q[k] * signs.rotation[k]);
    }
  }
  const size_t file_stride = header.sh_bytes();
  const auto stride = static_cast<size_t>(model.sh_rest_stride());
  const uint8_t* const harmonics = arrays.Take(file_stride * count);
  for (size_t i = 0; i < count; ++i) {
    for (size_t k = 0; k < stride; ++k) {
      model.sh_rest[stride * i + k] = static_cast<float>(
          (harmonics[file_stride * i + k] / 128.0 - 1) * signs.sh[k / 3]);
    }
  }
  return model;
}

}  // namespace

StatusOr<std::string> SerializeSpz(const GaussianModel& model,
                                   const SpzOptions& options) {
  const size_t count = model.size();
  if (count > kMaxSpzGaussians) {
    return BadInputError(std::to_string(count) +
                         " Gaussians are more than the 10 million of .spz");
  }
  if (!model.AllFinite()) {
    return BadInputError("the model has values that are NaN or infinite");
  }
  FREEGS_ASSIGN_OR_RETURN(const int bits, FractionalBits(model));
  const AxisSigns signs = SignsBetween(
      kRightDownFront, options.flip_axes ? kRightUpBack : kRightDownFront);
  SpzHeader header;
  header.count = static_cast<uint32_t>(count);
  header.sh_degree =
      static_cast<uint8_t>(std::clamp(options.sh_degree, 0, model.sh_degree));
  header.fractional_bits = static_cast<uint8_t>(bits);
  header.flags = model.antialiased ? kAntialiasedFlag : 0;

  ByteWriter writer;
  writer.Reserve(header.content_bytes());
  writer.PutBytes(kMagic);
  writer.Put(header.version);
  writer.Put(header.count);
  writer.Put(header.sh_degree);
  writer.Put(header.fractional_bits);
  writer.Put(header.flags);
  writer.Put(header.reserved);
  const double steps = std::ldexp(1.0, bits);
  for (size_t i = 0; i < count; ++i) {
    PutPosition(&model.means[3 * i], steps, signs, &writer);
  }
  for (const float logit : model.opacity_logits) {
    writer.Put(ToSpzByte(255 / (1 + std::exp(-static_cast<double>(logit)))));
  }
  for (const float dc : model.sh_dc) {
    writer.Put(ToSpzByte(255 * (0.5 + kColorScale * dc)));
  }
  for (const float log_scale : model.log_scales) {
    writer.Put(ToSpzByte((log_scale - kMinLogScale) * kScaleSteps));
  }
  for (size_t i = 0; i < count; ++i) {
    writer.Put(PackRotation(FileRotation(&model.rotations[4 * i], signs)));
  }
  const size_t stride = header.sh_bytes();
  for (size_t i = 0; i < count; ++i) {
    const float* const sh = model.sh_rest.data() + model.sh_rest_stride() * i;
    for (size_t k = 0; k < stride; ++k) {
      const auto coefficient = static_cast<int>(k / 3);
      writer.Put(ShByte(sh[k] * signs.sh[coefficient], coefficient));
    }
  }
  return Gzip(writer.content());
}

Status WriteSpz(const std::filesystem::path& path,
                const GaussianModel& model,
                const SpzOptions& options) {
  const StatusOr<std::string> content = SerializeSpz(model, options);
  const Status status = content.ok() ? CheckSpzSizes(model) : content.status();
  if (!status.ok()) return status.Annotated(path.string());
  return WriteFileAtomic(path, *content);
}

StatusOr<GaussianModel> ParseSpz(std::string_view bytes, bool flip_axes) {
  FREEGS_ASSIGN_OR_RETURN(const SpzHeader header,
                          UnpackHeader(bytes, bytes.size()));
  const bool extended = (header.flags & kExtensionsFlag) != 0;
  const uint64_t wanted = header.content_bytes();
  FREEGS_ASSIGN_OR_RETURN(
      const std::string content,
      Gunzip(bytes, wanted + (extended ? kMaxExtensionBytes : 0)));
  if (content.size() < wanted) {
    return BadInputError("the header promises " + std::to_string(header.count) +
                         " Gaussians, the content holds fewer");
  }
  uint32_t frame = kRightDownFront;
  if (flip_axes) {
    FREEGS_ASSIGN_OR_RETURN(
        frame,
        SpzFrame(extended ? std::string_view(content).substr(wanted) : ""));
  }
  return Decode(header, content, SignsBetween(frame, kRightDownFront));
}

StatusOr<size_t> CountSpzGaussians(std::string_view beginning,
                                   uint64_t file_bytes) {
  FREEGS_ASSIGN_OR_RETURN(const SpzHeader header,
                          UnpackHeader(beginning, file_bytes));
  return header.count;
}

StatusOr<GaussianModel> ReadSpz(const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string content, ReadFile(path));
  StatusOr<GaussianModel> model = ParseSpz(content);
  if (!model.ok()) return model.status().Annotated(path.string());
  return model;
}

}  // namespace freegs::splat
