// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip_export/safetensors.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "core/io/json_fields.h"

namespace freegs::semantics {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// The header of a CLIP takes 100 kB.
constexpr uint64_t kMaxHeaderBytes = uint64_t{1} << 24;
// Keeps products of sides, and offsets, far from overflow.
constexpr int64_t kMaxElements = int64_t{1} << 40;
constexpr size_t kMaxSides = 8;
// The most elements that fit into an ONNX file, whose size is below 2 GB.
constexpr uint64_t kMaxReadElements = uint64_t{1} << 29;

// Bytes of an element of the types that the format knows, 0 for others.
uint64_t ElementBytes(const std::string& dtype) {
  static constexpr std::pair<const char*, int> kTypes[] = {{"F64", 8},
                                                           {"F32", 4},
                                                           {"F16", 2},
                                                           {"BF16", 2},
                                                           {"I64", 8},
                                                           {"I32", 4},
                                                           {"I16", 2},
                                                           {"I8", 1},
                                                           {"U64", 8},
                                                           {"U32", 4},
                                                           {"U16", 2},
                                                           {"U8", 1},
                                                           {"BOOL", 1}};
  for (const auto& [name, bytes] : kTypes) {
    if (dtype == name) return static_cast<uint64_t>(bytes);
  }
  return 0;
}

StatusOr<TensorEntry> ParseEntry(const std::string& name, const json& value) {
  Status status;
  TensorEntry entry;
  JsonObjectReader fields(value, "", "tensor " + name, &status);
  entry.dtype = fields.Text("dtype");
  const uint64_t bytes = ElementBytes(entry.dtype);
  if (bytes == 0) fields.Fail("dtype", "is not a known type");
  const json& shape = fields.List("shape");
  if (shape.size() > kMaxSides) fields.Fail("shape", "has too many sides");
  int64_t elements = 1;
  for (const json& side : shape) {
    const StatusOr<int64_t> length =
        ReadInteger64(&side, 0, kMaxElements, fields.Where("shape"));
    if (!length.ok()) return length.status();
    if (*length > 0 && elements > kMaxElements / *length) {
      fields.Fail("shape", "is too large");
      break;
    }
    elements *= *length;
    entry.shape.push_back(*length);
  }
  const json& offsets = fields.List("data_offsets");
  if (offsets.size() != 2) fields.Fail("data_offsets", "must be two numbers");
  FREEGS_RETURN_IF_ERROR(status);
  const std::string where = fields.Where("data_offsets");
  FREEGS_ASSIGN_OR_RETURN(const int64_t begin,
                          ReadInteger64(&offsets[0], 0, INT64_MAX, where));
  FREEGS_ASSIGN_OR_RETURN(const int64_t end,
                          ReadInteger64(&offsets[1], begin, INT64_MAX, where));
  entry.begin = static_cast<uint64_t>(begin);
  entry.end = static_cast<uint64_t>(end);
  if (entry.end - entry.begin != static_cast<uint64_t>(elements) * bytes) {
    return BadInputError(where + ": " +
                         std::to_string(entry.end - entry.begin) +
                         " bytes are not " + ShapeText(entry.shape) +
                         " elements of type " + entry.dtype);
  }
  return entry;
}

// The tensors must follow one another from the first byte to the last.
Status CheckCoverage(const std::map<std::string, TensorEntry>& tensors,
                     uint64_t data_bytes) {
  std::vector<std::pair<const TensorEntry*, const std::string*>> order;
  for (const auto& [name, entry] : tensors) order.emplace_back(&entry, &name);
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first->begin, a.first->end) <
           std::pair(b.first->begin, b.first->end);
  });
  uint64_t covered = 0;
  for (const auto& [entry, name] : order) {
    if (entry->end > data_bytes) {
      return BadInputError("tensor " + *name +
                           " ends behind the end of the file: it was cut");
    }
    if (entry->begin != covered) {
      return BadInputError("tensor " + *name +
                           (entry->begin < covered
                                ? " overlaps the one before it"
                                : " leaves a gap before it"));
    }
    covered = entry->end;
  }
  if (covered != data_bytes) {
    return BadInputError(std::to_string(data_bytes - covered) +
                         " bytes at the end belong to no tensor");
  }
  return Status();
}

StatusOr<std::map<std::string, TensorEntry>> ParseHeader(
    const std::string& text, uint64_t data_bytes) {
  FREEGS_ASSIGN_OR_RETURN(const json header, ParseJsonObject(text));
  std::map<std::string, TensorEntry> tensors;
  for (const auto& [name, value] : header.items()) {
    if (name == "__metadata__") continue;
    FREEGS_ASSIGN_OR_RETURN(tensors[name], ParseEntry(name, value));
  }
  FREEGS_RETURN_IF_ERROR(CheckCoverage(tensors, data_bytes));
  return tensors;
}

template <typename T>
std::vector<float> Widen(const std::string& bytes) {
  std::vector<float> values(bytes.size() / sizeof(T));
  for (size_t i = 0; i < values.size(); ++i) {
    T value;
    std::memcpy(&value, bytes.data() + i * sizeof(T), sizeof(T));
    values[i] = static_cast<float>(value);
  }
  return values;
}

}  // namespace

std::string ShapeText(const std::vector<int64_t>& shape) {
  if (shape.empty()) return "one number";
  std::string text;
  for (const int64_t side : shape) {
    text += (text.empty() ? "" : " x ") + std::to_string(side);
  }
  return text;
}

Status SafetensorsFile::Error(const std::string& fault) const {
  return MissingDependencyError(path_.string() + ": " + fault);
}

StatusOr<SafetensorsFile> SafetensorsFile::Open(const fs::path& path) {
  SafetensorsFile file;
  file.path_ = path;
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) return file.Error("no such file");
  if (!fs::is_regular_file(status)) return file.Error("not a regular file");
  const uint64_t size = fs::file_size(path, error);
  std::ifstream stream(path, std::ios::binary);
  if (error || !stream) return file.Error("cannot be read");
  char bytes[8];
  uint64_t length = 0;
  if (size < sizeof(bytes) || !stream.read(bytes, sizeof(bytes))) {
    return file.Error("not a safetensors file: it is too short");
  }
  std::memcpy(&length, bytes, sizeof(length));
  if (length > size - sizeof(bytes)) {
    return file.Error(
        "its header is longer than the file: it was cut, or is not a "
        "safetensors file; download it again");
  }
  if (length > kMaxHeaderBytes) {
    return file.Error("its header of " + std::to_string(length) +
                      " bytes is larger than that of any CLIP");
  }
  std::string header(length, '\0');
  if (!stream.read(header.data(), static_cast<std::streamsize>(length))) {
    return file.Error("cannot be read");
  }
  file.data_begin_ = sizeof(bytes) + length;
  auto tensors = ParseHeader(header, size - file.data_begin_);
  if (!tensors.ok()) {
    return file.Error("damaged, or not a safetensors file: " +
                      tensors.status().message());
  }
  file.tensors_ = *std::move(tensors);
  return file;
}

StatusOr<std::vector<float>> SafetensorsFile::Read(
    const std::string& name, const std::vector<int64_t>& shape) const {
  const auto found = tensors_.find(name);
  if (found == tensors_.end()) return Error("it has no tensor " + name);
  const TensorEntry& entry = found->second;
  if (entry.shape != shape) {
    return Error("tensor " + name + " is " + ShapeText(entry.shape) + ", not " +
                 ShapeText(shape));
  }
  if (entry.dtype != "F32" && entry.dtype != "F16" && entry.dtype != "BF16") {
    return Error("tensor " + name + " has the type " + entry.dtype +
                 "; known are F32, F16 and BF16");
  }
  const uint64_t size = entry.end - entry.begin;
  if (size / ElementBytes(entry.dtype) > kMaxReadElements) {
    return Error("tensor " + name + " is larger than a network can be");
  }
  std::string bytes(size, '\0');
  std::ifstream stream(path_, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(data_begin_ + entry.begin));
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) {
    return Error("tensor " + name + " cannot be read");
  }
  std::vector<float> values = entry.dtype == "F32" ? Widen<float>(bytes)
                              : entry.dtype == "F16"
                                  ? Widen<Eigen::half>(bytes)
                                  : Widen<Eigen::bfloat16>(bytes);
  if (!std::all_of(values.begin(), values.end(), [](float value) {
        return std::isfinite(value);
      })) {
    return Error("tensor " + name + " has a number that is not finite");
  }
  return values;
}

}  // namespace freegs::semantics
