// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/model_info.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_fields.h"

namespace freegs::semantics {
namespace {

using nlohmann::json;

constexpr std::string_view kFormat = "FreeGS CLIP";
constexpr int kModelVersion = 1;
constexpr size_t kMaxWords = 10000;  // And groups of them.
constexpr int64_t kMaxModelFileBytes = 10'000'000'000'000;

std::array<float, 3> ReadColor(JsonObjectReader& reader,
                               const char* key,
                               double min,
                               double max) {
  const Eigen::Vector3d color = reader.Vector3(key);
  if (color.minCoeff() < min || color.maxCoeff() > max) {
    reader.Fail(key, "is out of range");
  }
  return {static_cast<float>(color[0]),
          static_cast<float>(color[1]),
          static_cast<float>(color[2])};
}

// A file of the folder itself: a name that leads nowhere else.
bool IsFileName(const std::string& name) {
  return !name.empty() && name.size() < 256 && name[0] != '.' &&
         name.find('/') == std::string::npos &&
         name.find('\0') == std::string::npos;
}

bool IsHash(const std::string& text) {
  return text.size() == 32 && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

void ReadDense(JsonObjectReader& top, Status* status, ModelInfo* info) {
  for (const json& item : top.List("dense")) {
    const std::string where =
        "dense[" + std::to_string(info->dense.size()) + "]";
    JsonObjectReader fields(item, "", where, status);
    info->dense.push_back({fields.Text("file"),
                           fields.Integer("image_size", 8, 4096),
                           fields.Integer("grid", 1, 1024)});
    const DenseNetwork& network = info->dense.back();
    if (network.grid > network.image_size) {
      fields.Fail("grid", "is larger than the image");
    }
  }
  if (info->dense.empty()) {
    top.Fail("dense", "must not be empty");
  } else if (info->dense[0].file != "dense.onnx") {
    top.Fail("dense[0].file", "must be dense.onnx");
  }
}

void ReadFiles(JsonObjectReader& top, Status* status, ModelInfo* info) {
  for (const auto& [name, value] : top.Object("files").items()) {
    JsonObjectReader fields(value, "", "files." + name, status);
    if (!IsFileName(name)) fields.Fail("", "is not the name of a file");
    ModelFile& file = info->files[name];
    file.bytes =
        static_cast<uint64_t>(fields.Integer64("bytes", 0, kMaxModelFileBytes));
    file.hash = fields.Text("hash");
    if (!IsHash(file.hash)) fields.Fail("hash", "must be 32 hex digits");
  }
  std::vector<std::string> required = {
      "visual.onnx", "text.onnx", "text_embedding", "vocab"};
  for (const DenseNetwork& network : info->dense) {
    required.push_back(network.file);
  }
  if (info->upsampled_size > 0) required.emplace_back("upsampler.onnx");
  for (const std::string& name : required) {
    if (info->files.count(name) == 0) top.Fail("files." + name, "is missing");
  }
}

// The words of a list, or nothing when it is not one of words, or empty.
std::vector<std::string> Words(const json& list) {
  std::vector<std::string> words;
  if (!list.is_array() || list.size() > kMaxWords) return {};
  for (const json& word : list) {
    if (!word.is_string() || word.get_ref<const std::string&>().empty()) {
      return {};
    }
    words.push_back(word.get<std::string>());
  }
  return words;
}

void ReadVocabulary(JsonObjectReader& top, ModelInfo* info) {
  const json& groups = top.List("vocabulary");
  if (groups.size() > kMaxWords) {
    return top.Fail("vocabulary", "has too many groups");
  }
  for (const json& group : groups) {
    info->vocabulary.push_back(Words(group));
    if (info->vocabulary.back().empty()) {
      return top.Fail("vocabulary", "must be a list of groups of words");
    }
  }
}

void ReadCanonical(JsonObjectReader& top, ModelInfo* info) {
  info->canonical = Words(top.List("canonical"));
  if (info->canonical.empty()) {
    top.Fail("canonical", "must be a list of phrases");
  }
}

}  // namespace

std::string ModelInfo::Hash() const {
  std::string text;
  const auto add = [&text](const auto&... numbers) {
    ((text += std::to_string(numbers) + " "), ...);
  };
  add(embedding_dim, image_size, context_length, text_width, vocab_size);
  if (upsampled_size > 0) add(upsampled_size);
  for (int i = 0; i < 3; ++i) {
    char number[64];
    std::snprintf(number, sizeof(number), "%a %a ", mean[i], std[i]);
    text += number;
  }
  for (const DenseNetwork& network : dense) {
    text += network.file + '\0';
    add(network.image_size, network.grid);
  }
  for (const auto& [name, file] : files) text += name + '\0' + file.hash;
  return HashBytes(text);
}

StatusOr<ModelInfo> ParseModelInfo(std::string_view text) {
  FREEGS_ASSIGN_OR_RETURN(const json root, ParseJsonObject(text));
  Status status;
  ModelInfo info;
  JsonObjectReader top(root, "", "", &status);
  if (top.Text("format") != kFormat) {
    top.Fail("format", "is not \"" + std::string(kFormat) + "\"");
  }
  if (top.Integer("version", 0, 1 << 30) != kModelVersion) {
    top.Fail("version",
             "is not " + std::to_string(kModelVersion) +
                 "; the folder is of another version of the program");
  }
  info.name = top.Text("name");
  info.licence = top.Text("licence");
  info.origin = top.Text("origin");
  info.embedding_dim = top.Integer("embedding_dim", 1, 1 << 14);
  info.image_size = top.Integer("image_size", 8, 4096);
  info.mean = ReadColor(top, "mean", -100, 100);
  info.std = ReadColor(top, "std", 1e-6, 100);
  info.context_length = top.Integer("context_length", 3, 4096);
  info.text_width = top.Integer("text_width", 1, 1 << 14);
  info.vocab_size = top.Integer("vocab_size", 515, 49408);
  ReadDense(top, &status, &info);
  if (top.Has("upsampled_size")) {
    info.upsampled_size = top.Integer("upsampled_size", 1, 2048);
  }
  if (top.Has("vocabulary")) ReadVocabulary(top, &info);
  if (top.Has("canonical")) ReadCanonical(top, &info);
  if (top.Has("min_word_confidence")) {
    info.min_word_confidence = top.Number("min_word_confidence", 0, 1);
  }
  ReadFiles(top, &status, &info);
  FREEGS_RETURN_IF_ERROR(status);
  return info;
}

}  // namespace freegs::semantics
