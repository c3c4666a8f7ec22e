// SPDX-License-Identifier: BSD-3-Clause

#include "splat/scene/ply_io.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/io/byte_stream.h"
#include "core/io/files.h"
#include "core/number_text.h"
#include "splat/scene/ply_header.h"

namespace freegs::splat {
namespace {

// How Brush marks such models, and what splat-transform reads.
constexpr const char* kAntialiasedLine = "comment SplatRenderMode: mip\n";

// Where a file property goes: array `parameter`, float `offset` of its group.
struct Target {
  Parameter parameter = Parameter::kMean;
  int offset = 0;
};

struct NamedTarget {
  std::string_view name;
  Target target;
};

constexpr std::array<NamedTarget, 14> kRequired = {{
    {"x", {Parameter::kMean, 0}},
    {"y", {Parameter::kMean, 1}},
    {"z", {Parameter::kMean, 2}},
    {"f_dc_0", {Parameter::kShDc, 0}},
    {"f_dc_1", {Parameter::kShDc, 1}},
    {"f_dc_2", {Parameter::kShDc, 2}},
    {"opacity", {Parameter::kOpacityLogit, 0}},
    {"scale_0", {Parameter::kLogScale, 0}},
    {"scale_1", {Parameter::kLogScale, 1}},
    {"scale_2", {Parameter::kLogScale, 2}},
    {"rot_0", {Parameter::kRotation, 0}},
    {"rot_1", {Parameter::kRotation, 1}},
    {"rot_2", {Parameter::kRotation, 2}},
    {"rot_3", {Parameter::kRotation, 3}},
}};

constexpr std::string_view kRestPrefix = "f_rest_";

// The standard deviation of Mip-Splatting's 3D filter, in world units.
constexpr std::string_view kFilter = "filter_3D";

// The number of "f_rest_12", or -1 for another name.
int RestNumber(std::string_view name) {
  if (!name.starts_with(kRestPrefix)) return -1;
  name.remove_prefix(kRestPrefix.size());
  int number = -1;
  const char* const end = name.data() + name.size();
  const auto [stop, error] = std::from_chars(name.data(), end, number);
  return error == std::errc() && stop == end ? number : -1;
}

// Float of sh_rest's group for f_rest_<number>: channel-major to
// coefficient-major.
int RestOffset(int number, int coefficients) {
  const int channel = number / coefficients;
  const int k = number % coefficients;
  return k * 3 + channel;
}

// The SH degree of the file, which can be higher than that of a model.
StatusOr<int> FileDegreeOf(const PlyElement& vertex) {
  const auto count = std::count_if(
      vertex.properties.begin(),
      vertex.properties.end(),
      [](const PlyProperty& p) { return RestNumber(p.name) >= 0; });
  for (int degree = 0; degree <= kMaxFileShDegree; ++degree) {
    if (count == 3 * (NumShCoefficients(degree) - 1)) return degree;
  }
  return BadInputError("has " + std::to_string(count) +
                       " f_rest properties; 0, 9, 24, 45 or 72 are a whole "
                       "SH degree");
}

// For each property of the vertices, its place in the model if it has one.
struct PropertyPlan {
  bool wanted = false;
  Target target = {};
  bool is_filter = false;  // It is kFilter, which changes other numbers.
};

// `degree` is that of the model, at most that of the file.
StatusOr<std::vector<PropertyPlan>> PlanProperties(const PlyElement& vertex,
                                                   int file_degree,
                                                   int degree) {
  const int file_coefficients = NumShCoefficients(file_degree) - 1;
  const int coefficients = NumShCoefficients(degree) - 1;
  std::vector<PropertyPlan> plan(vertex.properties.size());
  std::vector<std::string> missing;
  const auto place = [&](std::string_view name, const PropertyPlan& property) {
    bool found = false;
    for (size_t i = 0; i < plan.size(); ++i) {
      if (vertex.properties[i].name != name) continue;
      if (vertex.properties[i].is_list) {
        return BadInputError("property " + std::string(name) + " is a list");
      }
      if (found) {
        return BadInputError("property " + std::string(name) +
                             " appears twice");
      }
      found = true;
      plan[i] = property;
    }
    if (!found && !property.is_filter) missing.emplace_back(name);
    return Status();
  };
  FREEGS_RETURN_IF_ERROR(place(kFilter, {.wanted = true, .is_filter = true}));
  for (const NamedTarget& required : kRequired) {
    FREEGS_RETURN_IF_ERROR(place(required.name, {true, required.target}));
  }
  for (int number = 0; number < 3 * file_coefficients; ++number) {
    const bool held = number % file_coefficients < coefficients;
    FREEGS_RETURN_IF_ERROR(place(
        std::string(kRestPrefix) + std::to_string(number),
        {held, {Parameter::kShRest, RestOffset(number, file_coefficients)}}));
  }
  if (missing.empty()) return plan;
  if (std::ranges::find(vertex.properties,
                        "packed_position",
                        &PlyProperty::name) != vertex.properties.end()) {
    return BadInputError(
        "a compressed .ply, whose Gaussians are packed into a few numbers "
        "each; save the scene as an uncompressed .ply");
  }
  std::string names;
  for (const std::string& name : missing) names += " " + name;
  return BadInputError("not a Gaussian splat: the vertices lack" + names);
}

Status TruncatedError(const PlyElement& element, uint64_t index) {
  return BadInputError("content ends or is malformed in " + element.name + " " +
                       std::to_string(index) + " of " +
                       std::to_string(element.count));
}

Status SkipElement(const PlyElement& element, PlyValueReader* reader) {
  if (element.properties.empty()) return Status();
  for (uint64_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      if (!reader->Skip(property)) return TruncatedError(element, i);
    }
  }
  return Status();
}

// Rotations are normalised when they are used, in floats. Those that are too
// small for it have no direction; larger ones are made smaller.
void BringRotationIntoRange(float* q) {
  double squared = 0;
  for (int k = 0; k < 4; ++k) squared += static_cast<double>(q[k]) * q[k];
  const double norm = std::sqrt(squared);
  if (norm < 1e-9) {
    const float identity[] = {1, 0, 0, 0};
    std::copy_n(identity, 4, q);
  } else if (norm > 1e9) {
    for (int k = 0; k < 4; ++k) q[k] = static_cast<float>(q[k] / norm);
  }
}

// Mip-Splatting (Yu et al. 2024) and programs that descend from it store
// Gaussians without the 3D filter with which they were trained. The filter is a
// Gaussian: its variance is added along each axis, and opacity falls as much as
// the volume grows. All is computed with logarithms, because products of
// squared scales leave the range of numbers.
void FuseFilter(double filter, float* log_scales, float* opacity_logit) {
  if (filter == 0) return;
  const double log_filter = std::log(std::abs(filter));
  double log_factor = 0;  // Log of the factor of opacity.
  for (int k = 0; k < 3; ++k) {
    const double old = log_scales[k];
    const double larger = std::max(old, log_filter);
    const double smaller = std::min(old, log_filter);
    const double fused =
        larger + std::log1p(std::exp(2 * (smaller - larger))) / 2;
    log_scales[k] = static_cast<float>(fused);
    log_factor += old - fused;
  }
  // opacity = 1 / (1 + exp(-logit)), without overflow for any logit.
  const double logit = *opacity_logit;
  const double log_opacity = std::min(logit, 0.0) -
                             std::log1p(std::exp(-std::abs(logit))) +
                             log_factor;
  const double fused_logit = log_opacity - std::log(-std::expm1(log_opacity));
  // An opacity of exp(-100) is as good as none, and its logit stays finite.
  // Opacity does not grow; this also holds where it rounds to 1.
  constexpr double kLeastLogit = -100;
  *opacity_logit =
      static_cast<float>(std::min(logit, std::max(fused_logit, kLeastLogit)));
}

StatusOr<GaussianModel> ReadVertices(PlyFormat format,
                                     const PlyElement& vertex,
                                     PlyValueReader* reader) {
  FREEGS_ASSIGN_OR_RETURN(const int file_degree, FileDegreeOf(vertex));
  const int degree = std::min(file_degree, kMaxShDegree);
  FREEGS_ASSIGN_OR_RETURN(const std::vector<PropertyPlan> plan,
                          PlanProperties(vertex, file_degree, degree));
  // This comes before memory is allocated, because the count may be wrong. An
  // ascii file may lack the last separator.
  const uint64_t most =
      (reader->remaining_bytes() + 1) / vertex.MinItemBytes(format);
  if (vertex.count > most) {
    return BadInputError("the header promises " + std::to_string(vertex.count) +
                         " vertices, the content holds at most " +
                         std::to_string(most));
  }
  GaussianModel model;
  model.sh_degree = degree;
  model.Resize(vertex.count);
  std::array<float*, kNumParameters> arrays{};
  std::array<int, kNumParameters> strides{};
  for (const Parameter parameter : kAllParameters) {
    arrays[static_cast<int>(parameter)] =
        ParameterArray(model, parameter).data();
    strides[static_cast<int>(parameter)] = ParameterStride(model, parameter);
  }

  uint64_t not_finite = 0;
  for (uint64_t i = 0; i < vertex.count; ++i) {
    bool finite = true;
    float filter = 0;
    for (size_t p = 0; p < plan.size(); ++p) {
      const PlyProperty& property = vertex.properties[p];
      if (!plan[p].wanted) {
        if (!reader->Skip(property)) return TruncatedError(vertex, i);
        continue;
      }
      double value = 0;
      if (!reader->Read(property.type, &value)) {
        return TruncatedError(vertex, i);
      }
      const float stored = static_cast<float>(value);
      finite = finite && std::isfinite(stored);
      if (plan[p].is_filter) {
        filter = stored;
        continue;
      }
      const int kind = static_cast<int>(plan[p].target.parameter);
      arrays[kind][i * strides[kind] + plan[p].target.offset] = stored;
    }
    if (finite) {
      FuseFilter(filter, &model.log_scales[3 * i], &model.opacity_logits[i]);
    } else {
      ++not_finite;
    }
    float* const q = arrays[static_cast<int>(Parameter::kRotation)] + 4 * i;
    BringRotationIntoRange(q);
  }
  if (not_finite > 0) {
    return BadInputError(std::to_string(not_finite) + " of " +
                         std::to_string(vertex.count) +
                         " vertices have values that are NaN or infinite");
  }
  return model;
}

}  // namespace

StatusOr<PlacedModel> ParsePly(std::string_view content) {
  FREEGS_ASSIGN_OR_RETURN(const PlyHeader header, ParsePlyHeader(content));
  PlyValueReader reader(header.format, content.substr(header.size));
  for (const PlyElement& element : header.elements) {
    if (element.name == "vertex") {
      PlacedModel placed;
      placed.offset = Eigen::Map<const Eigen::Vector3d>(header.offset.data());
      FREEGS_ASSIGN_OR_RETURN(placed.model,
                              ReadVertices(header.format, element, &reader));
      placed.model.antialiased = header.antialiased;
      return placed;
    }
    FREEGS_RETURN_IF_ERROR(SkipElement(element, &reader));
  }
  return BadInputError("PLY header has no element vertex");
}

StatusOr<PlacedModel> ReadPly(const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string content, ReadFile(path));
  StatusOr<PlacedModel> model = ParsePly(content);
  if (!model.ok()) return model.status().Annotated(path.string());
  return model;
}

std::string PlyOffsetLine(const Eigen::Vector3d& offset) {
  if (offset.isZero(0)) return "";
  return "comment offset " + FormatSignificant(offset.x(), 17) + " " +
         FormatSignificant(offset.y(), 17) + " " +
         FormatSignificant(offset.z(), 17) + "\n";
}

std::string SerializePly(const GaussianModel& model,
                         const Eigen::Vector3d& offset) {
  const int coefficients = NumShCoefficients(model.sh_degree) - 1;
  std::vector<std::string> names = {"x", "y", "z", "nx", "ny", "nz"};
  for (int c = 0; c < 3; ++c) names.push_back("f_dc_" + std::to_string(c));
  for (int k = 0; k < 3 * coefficients; ++k) {
    names.push_back(std::string(kRestPrefix) + std::to_string(k));
  }
  names.push_back("opacity");
  for (int k = 0; k < 3; ++k) names.push_back("scale_" + std::to_string(k));
  for (int k = 0; k < 4; ++k) names.push_back("rot_" + std::to_string(k));

  std::string header = "ply\nformat binary_little_endian 1.0\n" +
                       PlyOffsetLine(offset) +
                       (model.antialiased ? kAntialiasedLine : "") +
                       "element vertex " + std::to_string(model.size()) + "\n";
  for (const std::string& name : names) {
    header += "property float " + name + "\n";
  }
  header += "end_header\n";

  ByteWriter writer;
  writer.Reserve(header.size() + model.size() * names.size() * sizeof(float));
  writer.PutBytes(header);
  constexpr std::array<float, 3> kNormal = {0, 0, 0};
  std::array<float, 3 * (NumShCoefficients(kMaxShDegree) - 1)> rest{};
  for (size_t i = 0; i < model.size(); ++i) {
    writer.PutArray(&model.means[3 * i], 3);
    writer.PutArray(kNormal);
    writer.PutArray(&model.sh_dc[3 * i], 3);
    for (int number = 0; number < 3 * coefficients; ++number) {
      rest[number] =
          model
              .sh_rest[i * 3 * coefficients + RestOffset(number, coefficients)];
    }
    writer.PutArray(rest.data(), 3 * coefficients);
    writer.Put(model.opacity_logits[i]);
    writer.PutArray(&model.log_scales[3 * i], 3);
    writer.PutArray(&model.rotations[4 * i], 4);
  }
  return std::move(writer).content();
}

Status WritePly(const std::filesystem::path& path,
                const GaussianModel& model,
                const Eigen::Vector3d& offset) {
  return WriteFileAtomic(path, SerializePly(model, offset));
}

}  // namespace freegs::splat
