// SPDX-License-Identifier: BSD-3-Clause

#include "splat/scene/ply_header.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

namespace freegs::splat {
namespace {

// The names of elements are compared with each other. Scenes have one element,
// meshes two or three.
constexpr size_t kMaxElements = 100;

static_assert(std::endian::native == std::endian::little,
              "values are copied from little-endian files as they are");

bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

std::vector<std::string_view> Words(std::string_view line) {
  std::vector<std::string_view> words;
  size_t at = 0;
  while (at < line.size()) {
    if (IsSpace(line[at])) {
      ++at;
      continue;
    }
    const size_t first = at;
    while (at < line.size() && !IsSpace(line[at])) ++at;
    words.push_back(line.substr(first, at - first));
  }
  return words;
}

std::optional<PlyType> TypeNamed(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, PlyType>, 16> kNames =
      {{{"char", PlyType::kInt8},
        {"int8", PlyType::kInt8},
        {"uchar", PlyType::kUint8},
        {"uint8", PlyType::kUint8},
        {"short", PlyType::kInt16},
        {"int16", PlyType::kInt16},
        {"ushort", PlyType::kUint16},
        {"uint16", PlyType::kUint16},
        {"int", PlyType::kInt32},
        {"int32", PlyType::kInt32},
        {"uint", PlyType::kUint32},
        {"uint32", PlyType::kUint32},
        {"float", PlyType::kFloat32},
        {"float32", PlyType::kFloat32},
        {"double", PlyType::kFloat64},
        {"float64", PlyType::kFloat64}}};
  for (const auto& [known, type] : kNames) {
    if (known == name) return type;
  }
  return std::nullopt;
}

// The text of a line in a message: short and printable.
std::string Quoted(std::string_view line) {
  std::string text = "\"";
  for (const char c : line.substr(0, 60)) {
    text += c >= ' ' && c <= '~' ? c : '?';
  }
  return text + "\"";
}

Status ParseFormat(const std::vector<std::string_view>& words,
                   PlyHeader* header) {
  if (words.size() != 3 || words[2] != "1.0") {
    return BadInputError("PLY format line is not \"format KIND 1.0\"");
  }
  if (words[1] == "ascii") {
    header->format = PlyFormat::kAscii;
  } else if (words[1] == "binary_little_endian") {
    header->format = PlyFormat::kBinaryLittleEndian;
  } else if (words[1] == "binary_big_endian") {
    header->format = PlyFormat::kBinaryBigEndian;
  } else {
    return BadInputError("unknown PLY format " + Quoted(words[1]));
  }
  return Status();
}

Status ParseElement(const std::vector<std::string_view>& words,
                    PlyHeader* header) {
  if (words.size() != 3) {
    return BadInputError("PLY element line is not \"element NAME COUNT\"");
  }
  if (header->elements.size() == kMaxElements) {
    return BadInputError("PLY header has more than " +
                         std::to_string(kMaxElements) + " elements");
  }
  PlyElement element;
  element.name = words[1];
  // Indices into the items of an element would be into which one?
  for (const PlyElement& other : header->elements) {
    if (other.name == element.name) {
      return BadInputError("PLY header has two elements " + Quoted(words[1]));
    }
  }
  const char* const end = words[2].data() + words[2].size();
  const auto [stop, error] =
      std::from_chars(words[2].data(), end, element.count);
  if (error != std::errc() || stop != end) {
    return BadInputError("PLY element count " + Quoted(words[2]) +
                         " is not a whole number");
  }
  header->elements.push_back(std::move(element));
  return Status();
}

Status ParseProperty(const std::vector<std::string_view>& words,
                     PlyHeader* header) {
  if (header->elements.empty()) {
    return BadInputError("PLY property before any element");
  }
  PlyProperty property;
  property.is_list = words.size() == 5 && words[1] == "list";
  if (!property.is_list && words.size() != 3) {
    return BadInputError("PLY property line is not \"property TYPE NAME\"");
  }
  const std::optional<PlyType> type = TypeNamed(words[words.size() - 2]);
  const std::optional<PlyType> count_type =
      property.is_list ? TypeNamed(words[2]) : PlyType::kUint8;
  if (!type || !count_type || *count_type == PlyType::kFloat32 ||
      *count_type == PlyType::kFloat64) {
    return BadInputError("PLY property " + Quoted(words.back()) +
                         " is of an unknown type");
  }
  property.type = *type;
  property.count_type = *count_type;
  property.name = words.back();
  header->elements.back().properties.push_back(std::move(property));
  return Status();
}

// Other comments, and those whose numbers are not numbers, mean nothing.
void TakeComment(const std::vector<std::string_view>& words,
                 PlyHeader* header) {
  if (words.size() == 3 && words[1] == "SplatRenderMode:") {
    header->antialiased = words[2] == "mip";
  }
  if (words.size() != 5 || words[1] != "offset") return;
  std::array<double, 3> offset{};
  for (size_t k = 0; k < 3; ++k) {
    const std::string_view word = words[2 + k];
    const char* const end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, offset[k]);
    if (error != std::errc() || stop != end || !std::isfinite(offset[k])) {
      return;
    }
  }
  header->offset = offset;
}

template <typename T>
double Load(const char* bytes, bool swap) {
  std::array<char, sizeof(T)> value;
  std::memcpy(value.data(), bytes, sizeof(T));
  if (swap) std::reverse(value.begin(), value.end());
  return static_cast<double>(std::bit_cast<T>(value));
}

double Load(PlyType type, const char* bytes, bool swap) {
  switch (type) {
    case PlyType::kInt8:
      return Load<int8_t>(bytes, swap);
    case PlyType::kUint8:
      return Load<uint8_t>(bytes, swap);
    case PlyType::kInt16:
      return Load<int16_t>(bytes, swap);
    case PlyType::kUint16:
      return Load<uint16_t>(bytes, swap);
    case PlyType::kInt32:
      return Load<int32_t>(bytes, swap);
    case PlyType::kUint32:
      return Load<uint32_t>(bytes, swap);
    case PlyType::kFloat32:
      return Load<float>(bytes, swap);
    case PlyType::kFloat64:
      break;
  }
  return Load<double>(bytes, swap);
}

}  // namespace

size_t PlyTypeSize(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUint16:
      return 2;
    case PlyType::kInt32:
    case PlyType::kUint32:
    case PlyType::kFloat32:
      return 4;
    case PlyType::kFloat64:
      break;
  }
  return 8;
}

uint64_t PlyElement::MinItemBytes(PlyFormat format) const {
  uint64_t bytes = 0;
  for (const PlyProperty& property : properties) {
    if (format == PlyFormat::kAscii) {
      bytes += 2;  // A digit and a space.
    } else {
      bytes +=
          PlyTypeSize(property.is_list ? property.count_type : property.type);
    }
  }
  return bytes;
}

StatusOr<PlyHeader> ParsePlyHeader(std::string_view content) {
  PlyHeader header;
  bool has_format = false;
  size_t at = 0;
  for (size_t number = 0;; ++number) {
    const size_t end = content.find('\n', at);
    if (number == 0 && content.substr(at, 3) != "ply") {
      return BadInputError("not a PLY file");
    }
    if (end == std::string_view::npos) {
      return BadInputError("PLY header has no end_header line");
    }
    const std::string_view line = content.substr(at, end - at);
    at = end + 1;
    const std::vector<std::string_view> words = Words(line);
    if (words.empty() || words[0] == "obj_info") continue;
    if (words[0] == "comment") {
      TakeComment(words, &header);
      continue;
    }
    if (number == 0) {
      if (words.size() != 1 || words[0] != "ply") {
        return BadInputError("not a PLY file");
      }
    } else if (words[0] == "format") {
      FREEGS_RETURN_IF_ERROR(ParseFormat(words, &header));
      has_format = true;
    } else if (words[0] == "element") {
      FREEGS_RETURN_IF_ERROR(ParseElement(words, &header));
    } else if (words[0] == "property") {
      FREEGS_RETURN_IF_ERROR(ParseProperty(words, &header));
    } else if (words[0] == "end_header") {
      break;
    } else {
      return BadInputError("PLY header line " + Quoted(line) +
                           " is not understood");
    }
  }
  if (!has_format) return BadInputError("PLY header has no format line");
  header.size = at;
  return header;
}

bool PlyValueReader::ReadToken(double* value) {
  size_t first = 0;
  while (first < rest_.size() && IsSpace(rest_[first])) ++first;
  if (first < rest_.size() && rest_[first] == '+') ++first;
  rest_.remove_prefix(first);
  const char* const start = rest_.data();
  const auto [stop, error] =
      std::from_chars(start, start + rest_.size(), *value);
  if (error == std::errc::invalid_argument) return false;
  if (error == std::errc::result_out_of_range) {
    // from_chars does not tell whether the number is too large or too small;
    // the sign of the exponent does.
    const std::string_view token(start, static_cast<size_t>(stop - start));
    const bool tiny = token.find("e-") != std::string_view::npos ||
                      token.find("E-") != std::string_view::npos;
    *value = tiny ? 0.0 : std::numeric_limits<double>::infinity();
  }
  rest_.remove_prefix(static_cast<size_t>(stop - rest_.data()));
  return rest_.empty() || IsSpace(rest_.front());
}

bool PlyValueReader::Read(PlyType type, double* value) {
  if (format_ == PlyFormat::kAscii) return ReadToken(value);
  const size_t size = PlyTypeSize(type);
  if (rest_.size() < size) return false;
  *value = Load(type, rest_.data(), format_ == PlyFormat::kBinaryBigEndian);
  rest_.remove_prefix(size);
  return true;
}

bool PlyValueReader::Skip(const PlyProperty& property) {
  double value = 0;
  if (!property.is_list) return Read(property.type, &value);
  if (!Read(property.count_type, &value)) return false;
  // Also false for NaN. Integer types up to 32 bits fit.
  if (!(value >= 0 && value <= 4294967295.0)) return false;
  const auto count = static_cast<uint64_t>(value);
  if (format_ == PlyFormat::kAscii) {
    for (uint64_t i = 0; i < count; ++i) {
      if (!ReadToken(&value)) return false;
    }
    return true;
  }
  const uint64_t bytes = count * PlyTypeSize(property.type);
  if (bytes > rest_.size()) return false;
  rest_.remove_prefix(bytes);
  return true;
}

}  // namespace freegs::splat
