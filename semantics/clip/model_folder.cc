// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/model_folder.h"

#include <system_error>
#include <utility>

#include "core/io/files.h"

namespace freegs::semantics {
namespace {

namespace fs = std::filesystem;

constexpr char kInfoFile[] = "model.json";
constexpr uint64_t kMaxInfoBytes = 1 << 20;

Status ModelError(const std::string& what) {
  return MissingDependencyError(
      what +
      "; write it anew with freegs_pipeline model, or name another model "
      "folder");
}

Status CheckFile(const ModelFolder& folder,
                 const std::string& name,
                 const ModelFile& expected) {
  const fs::path path = folder.path / name;
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) return folder.FileError(name, "no such file");
  if (!fs::is_regular_file(status)) {
    return folder.FileError(name, "not a regular file");
  }
  const uint64_t bytes = fs::file_size(path, error);
  if (!error && bytes != expected.bytes) {
    return folder.FileError(name,
                            std::to_string(bytes) + " bytes instead of the " +
                                std::to_string(expected.bytes) +
                                " that model.json names");
  }
  const StatusOr<std::string> hash = HashFile(path);
  if (!hash.ok()) return ModelError(hash.status().message());
  if (*hash != expected.hash) {
    return folder.FileError(
        name, "its content is not what model.json names (hash " + *hash + ")");
  }
  return Status();
}

}  // namespace

StatusOr<ModelFolder> ModelFolder::Open(const fs::path& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    return ModelError(path.string() + ": no such model folder");
  }
  ModelFolder folder;
  folder.path = path;
  const StatusOr<std::string> text = ReadFile(path / kInfoFile, kMaxInfoBytes);
  if (!text.ok()) return ModelError(text.status().message());
  StatusOr<ModelInfo> info = ParseModelInfo(*text);
  if (!info.ok()) {
    return folder.FileError(kInfoFile, info.status().message());
  }
  folder.info = *std::move(info);
  for (const auto& [name, file] : folder.info.files) {
    FREEGS_RETURN_IF_ERROR(CheckFile(folder, name, file));
  }
  return folder;
}

StatusOr<BytePairTokenizer> ModelFolder::LoadTokenizer() const {
  StatusOr<BytePairTokenizer> tokenizer =
      BytePairTokenizer::Load(path / "vocab");
  if (!tokenizer.ok()) return ModelError(tokenizer.status().message());
  if (tokenizer->vocab_size() != info.vocab_size) {
    return FileError("vocab",
                     "it makes " + std::to_string(tokenizer->vocab_size()) +
                         " tokens, not the " + std::to_string(info.vocab_size) +
                         " that model.json names");
  }
  return tokenizer;
}

StatusOr<TokenTable> ModelFolder::LoadTokenTable() const {
  StatusOr<TokenTable> table = TokenTable::Load(path / "text_embedding");
  if (!table.ok()) return ModelError(table.status().message());
  if (table->rows() != info.vocab_size || table->columns() != info.text_width) {
    return FileError(
        "text_embedding",
        std::to_string(table->rows()) + " x " +
            std::to_string(table->columns()) + " numbers, not the " +
            std::to_string(info.vocab_size) + " x " +
            std::to_string(info.text_width) + " that model.json names");
  }
  return table;
}

Status ModelFolder::FileError(const std::string& name,
                              const std::string& fault) const {
  return ModelError((path / name).string() + ": " + fault);
}

}  // namespace freegs::semantics
