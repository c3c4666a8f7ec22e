// SPDX-License-Identifier: BSD-3-Clause
// Folders of CLIP models, and the weights that they are made of.

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/gzip.h"
#include "semantics/clip/byte_pair_tokenizer.h"
#include "semantics/clip/model_folder.h"
#include "semantics/clip/opencv_clip.h"
#include "semantics/clip/token_table.h"
#include "semantics/clip_export/clip_checkpoint.h"
#include "tests/fuzz/reader.h"

namespace freegs::fuzz {
namespace {

namespace fs = std::filesystem;

const fs::path kTinyClip =
    fs::path(FREEGS_SOURCE_DIR) / "tests/semantics/clip/data/tiny_clip";

// A folder with the tiny model, whose files a reader replaces.
fs::path ModelCopy() {
  static const fs::path copy = [] {
    fs::copy(kTinyClip, Scratch() / "model");
    return Scratch() / "model";
  }();
  return copy;
}

// Puts a file into the copy as if it belonged there.
void Replace(const std::string& name, std::string_view content) {
  WriteText(ModelCopy() / name, content);
  auto info = nlohmann::json::parse(ReadText(kTinyClip / "model.json"));
  info["files"][name] = {{"bytes", content.size()},
                         {"hash", HashBytes(content)}};
  WriteText(ModelCopy() / "model.json", info.dump());
}

// A safetensors file of a header and zeros.
std::string SafetensorsOf(const nlohmann::json& header, size_t num_bytes) {
  const std::string text = header.dump();
  ByteWriter writer;
  writer.Put<uint64_t>(text.size());
  writer.PutBytes(text);
  writer.PutBytes(std::string(num_bytes, '\0'));
  return std::move(writer).content();
}

std::vector<FolderFile> WeightFiles() {
  return {
      {"model.safetensors",
       SafetensorsOf(
           {{"logit_scale",
             {{"dtype", "F32"},
              {"shape", nlohmann::json::array()},
              {"data_offsets", {0, 4}}}},
            {"visual_projection.weight",
             {{"dtype", "F16"}, {"shape", {2, 3}}, {"data_offsets", {4, 16}}}}},
           16)},
      {"config.json",
       R"({"text_config": {"num_attention_heads": 2, "hidden_act": "gelu",
"layer_norm_eps": 1e-5, "hidden_size": 16}, "vision_config":
{"num_attention_heads": 2, "hidden_size": 16, "patch_size": 8,
"image_size": 16}})"},
      {"preprocessor_config.json",
       R"({"image_mean": [0.5, 0.5, 0.5], "image_std": [0.2, 0.2, 0.2]})"}};
}

}  // namespace

Reader ModelFolder() {
  return {[](std::string_view bytes) {
            WriteText(ModelCopy() / "model.json", bytes);
            const auto folder = semantics::ModelFolder::Open(ModelCopy());
            if (!folder.ok()) return;
            (void)folder->info.Hash();
            (void)folder->LoadTokenizer();
            (void)folder->LoadTokenTable();
          },
          [] {
            return std::vector<std::string>{
                ReadText(kTinyClip / "model.json"),
                ReadText(fs::path(FREEGS_SOURCE_DIR) /
                         "models/small_clip/model.json")};
          }};
}

// A network that is what model.json says. OpenCV reads it.
Reader Network() {
  return {[](std::string_view bytes) {
            Replace("visual.onnx", bytes);
            const auto clip = semantics::OpenCvClip::Open(ModelCopy());
            Require(clip.ok());
            (void)(*clip)->EncodeImage(ImageU8(20, 20, 3, 100));
          },
          [] {
            return std::vector<std::string>{
                ReadText(kTinyClip / "visual.onnx"),
                ReadText(kTinyClip.parent_path() / "upsampler.onnx")};
          }};
}

Reader Safetensors() {
  return {[](std::string_view bytes) {
            static const std::vector<FolderFile> files = WeightFiles();
            WriteWithOneReplaced(Scratch() / "weights", files, bytes);
            (void)semantics::ClipCheckpoint::Open(Scratch() / "weights");
            const auto file = semantics::SafetensorsFile::Open(
                Scratch() / "weights/model.safetensors");
            if (!file.ok()) return;
            for (const auto& [name, entry] : file->tensors()) {
              (void)file->Read(name, entry.shape);
            }
          },
          [] { return SeedsOfFolder(WeightFiles()); }};
}

Reader TokenTable() {
  return {[](std::string_view bytes) {
            const auto table = semantics::TokenTable::Parse(std::string(bytes));
            if (!table.ok()) return;
            Require(table->rows() > 0 && table->columns() > 0);
            std::vector<float> row(static_cast<size_t>(table->columns()));
            table->CopyRow(0, row);
            table->CopyRow(table->rows() - 1, row);
          },
          [] {
            std::vector<std::string> seeds;
            for (const uint32_t type : {0u, 1u}) {
              ByteWriter writer;
              writer.PutBytes("FREEGSTT");
              for (const uint32_t value : {1u, type, 3u, 2u}) {
                writer.Put(value);
              }
              writer.PutBytes(std::string(3 * 2 * (type == 0 ? 4 : 2), '\0'));
              seeds.push_back(std::move(writer).content());
            }
            return seeds;
          }};
}

// Merges, plain or packed. Texts of the same bytes are tokenised with them.
Reader Vocabulary() {
  return {
      [](std::string_view bytes) {
        constexpr uint64_t kMaxBytes = 1 << 22;
        (void)IsGzip(bytes);
        (void)Gunzip(bytes, kMaxBytes);
        WriteText(Scratch() / "vocab", bytes);
        const auto tokenizer =
            semantics::BytePairTokenizer::Load(Scratch() / "vocab");
        if (!tokenizer.ok()) return;
        for (const int length : {3, 77}) {
          const auto text = tokenizer->Tokenize(bytes, length);
          if (!text.ok()) continue;
          Require(text->ids.size() <= static_cast<size_t>(length));
          for (const int32_t id : text->ids) {
            Require(id >= 0 && id < tokenizer->vocab_size());
          }
        }
      },
      [] {
        return std::vector<std::string>{
            ReadText(kTinyClip / "vocab"),
            ReadText(fs::path(FREEGS_SOURCE_DIR) / "models/small_clip/vocab")};
      }};
}

}  // namespace freegs::fuzz
