// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/model_info.h"

#include <algorithm>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "core/io/files.h"

namespace freegs::semantics {
namespace {

using nlohmann::json;

constexpr std::string_view kFormat = "FreeGS CLIP";
constexpr int kVersion = 1;
constexpr int kMaxDepth = 8;
constexpr size_t kMaxWords = 10000;  // And groups of them.
constexpr double kMaxFileBytes = 1e13;

// Reads fields of an object; keeps the first fault.
class Fields {
 public:
  Fields(const json& object, std::string where, std::string* fault)
      : object_(object), where_(std::move(where)), fault_(*fault) {
    if (!object.is_object()) Fail("", "is not an object");
  }

  std::string Text(const char* key) {
    const json* field = Find(key);
    if (field == nullptr) return "";
    if (!field->is_string()) {
      Fail(key, "is not a text");
      return "";
    }
    return field->get<std::string>();
  }

  bool Has(const char* key) const {
    return object_.is_object() && object_.contains(key);
  }

  // A number in [min, max].
  double Number(const char* key, double min, double max) {
    const json* field = Find(key);
    if (field == nullptr) return min;
    return CheckedNumber(*field, key, min, max);
  }

  int Int(const char* key, int min, int max) {
    const json* field = Find(key);
    if (field != nullptr && !field->is_number_integer()) {
      Fail(key, "is not a whole number");
      return min;
    }
    return static_cast<int>(Number(key, min, max));
  }

  std::array<float, 3> Color(const char* key, double min, double max) {
    std::array<float, 3> color = {};
    const json* field = Find(key);
    if (field == nullptr) return color;
    if (!field->is_array() || field->size() != 3) {
      Fail(key, "is not a list of three numbers");
      return color;
    }
    for (size_t i = 0; i < 3; ++i) {
      color[i] = static_cast<float>(CheckedNumber((*field)[i], key, min, max));
    }
    return color;
  }

  // Null after a fault, which a field of another type is.
  const json* Find(const char* key) {
    if (!fault_.empty()) return nullptr;
    const auto found = object_.find(key);
    if (found == object_.end()) {
      Fail(key, "is missing");
      return nullptr;
    }
    return &*found;
  }

  void Fail(const std::string& key, const std::string& what) {
    if (!fault_.empty()) return;
    fault_ = where_ + key + " " + what;
  }

 private:
  double CheckedNumber(const json& field,
                       const char* key,
                       double min,
                       double max) {
    if (!field.is_number()) {
      Fail(key, "is not a number");
      return min;
    }
    const double number = field.get<double>();
    if (!(number >= min && number <= max)) {
      Fail(key, "is out of range");
      return min;
    }
    return number;
  }

  const json& object_;
  const std::string where_;
  std::string& fault_;
};

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

void ReadDense(Fields& top, std::string* fault, ModelInfo* info) {
  const json* list = top.Find("dense");
  if (list == nullptr) return;
  if (!list->is_array() || list->empty()) {
    return top.Fail("dense", "is not a list of networks");
  }
  for (const json& item : *list) {
    const std::string where =
        "dense[" + std::to_string(info->dense.size()) + "].";
    Fields fields(item, where, fault);
    info->dense.push_back({fields.Text("file"),
                           fields.Int("image_size", 8, 4096),
                           fields.Int("grid", 1, 1024)});
    const DenseNetwork& network = info->dense.back();
    if (network.grid > network.image_size) {
      fields.Fail("grid", "is larger than the image");
    }
  }
  if (info->dense[0].file != "dense.onnx") {
    top.Fail("dense[0].file", "is not dense.onnx");
  }
}

void ReadFiles(Fields& top, std::string* fault, ModelInfo* info) {
  const json* files = top.Find("files");
  if (files == nullptr) return;
  if (!files->is_object()) return top.Fail("files", "is not an object");
  for (const auto& [name, value] : files->items()) {
    Fields fields(value, "files." + name + ".", fault);
    if (!IsFileName(name)) fields.Fail("", "is not the name of a file");
    ModelFile& file = info->files[name];
    file.bytes =
        static_cast<uint64_t>(fields.Number("bytes", 0, kMaxFileBytes));
    file.hash = fields.Text("hash");
    if (!IsHash(file.hash)) fields.Fail("hash", "is not 32 hex digits");
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

void ReadVocabulary(Fields& top, ModelInfo* info) {
  const json* groups = top.Find("vocabulary");
  if (groups == nullptr) return;
  if (!groups->is_array() || groups->size() > kMaxWords) {
    return top.Fail("vocabulary", "is not a list");
  }
  for (const json& group : *groups) {
    info->vocabulary.push_back(Words(group));
    if (info->vocabulary.back().empty()) {
      return top.Fail("vocabulary", "is not a list of groups of words");
    }
  }
}

void ReadCanonical(Fields& top, ModelInfo* info) {
  const json* phrases = top.Find("canonical");
  if (phrases == nullptr) return;
  info->canonical = Words(*phrases);
  if (info->canonical.empty()) {
    top.Fail("canonical", "is not a list of phrases");
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
  // What lies deeper is dropped while parsing, so that hostile nesting costs no
  // memory.
  const json root = json::parse(
      text,
      [](int depth, json::parse_event_t, json&) { return depth <= kMaxDepth; },
      /*allow_exceptions=*/false);
  if (root.is_discarded()) return BadInputError("not valid JSON");
  std::string fault;
  ModelInfo info;
  Fields top(root, "", &fault);
  if (!fault.empty()) return BadInputError("the document is not an object");
  if (top.Text("format") != kFormat) {
    top.Fail("format", "is not \"" + std::string(kFormat) + "\"");
  }
  if (top.Int("version", 0, 1 << 30) != kVersion) {
    top.Fail("version",
             "is not " + std::to_string(kVersion) +
                 "; the folder is of another version of the program");
  }
  info.name = top.Text("name");
  info.licence = top.Text("licence");
  info.origin = top.Text("origin");
  info.embedding_dim = top.Int("embedding_dim", 1, 1 << 14);
  info.image_size = top.Int("image_size", 8, 4096);
  info.mean = top.Color("mean", -100, 100);
  info.std = top.Color("std", 1e-6, 100);
  info.context_length = top.Int("context_length", 3, 4096);
  info.text_width = top.Int("text_width", 1, 1 << 14);
  info.vocab_size = top.Int("vocab_size", 515, 49408);
  ReadDense(top, &fault, &info);
  if (top.Has("upsampled_size")) {
    info.upsampled_size = top.Int("upsampled_size", 1, 2048);
  }
  if (top.Has("vocabulary")) ReadVocabulary(top, &info);
  if (top.Has("canonical")) ReadCanonical(top, &info);
  ReadFiles(top, &fault, &info);
  if (!fault.empty()) return BadInputError(fault);
  return info;
}

}  // namespace freegs::semantics
