// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip_export/clip_export.h"

#include <cmath>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "core/io/byte_stream.h"
#include "core/io/files.h"
#include "core/io/json_fields.h"
#include "core/io/json_text.h"
#include "semantics/clip/byte_pair_tokenizer.h"
#include "semantics/clip_export/clip_checkpoint.h"
#include "semantics/clip_export/clip_networks.h"

namespace freegs::semantics {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kMaxDenseSize = 4096;  // As model.json allows.

// The temporary folders beside `out`: the new model, and the one that it
// replaces. Nobody gives such a name to a copy that is to be kept, so what an
// export has left there may be deleted.
constexpr char kNew[] = ".part";
constexpr char kReplaced[] = ".replaced.part";

fs::path Beside(const fs::path& out, const char* suffix) {
  return out.string() + suffix;
}

// Whether a folder holds a model, whatever its state.
bool IsModelFolder(const fs::path& folder) {
  const StatusOr<std::string> text =
      ReadFile(folder / "model.json", uint64_t{1} << 20);
  if (!text.ok()) return false;
  const StatusOr<json> info = ParseJsonObject(*text);
  if (!info.ok()) return false;
  const json* format = FindField(*info, "format");
  return format != nullptr && *format == "FreeGS CLIP";
}

// Whether all in a folder are files that an export that was stopped leaves.
bool IsLeftover(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) return false;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(folder, error)) {
    fs::path name = entry.path().filename();
    if (name.extension() == ".part") name = name.stem();
    if (!entry.is_regular_file(error) ||
        (name.extension() != ".onnx" && name != "text_embedding" &&
         name != "vocab" && name != "model.json")) {
      return false;
    }
  }
  return !error;
}

Status InTheWay(const fs::path& path) {
  return BadInputError(path.string() +
                       ": is in the way of a temporary folder; move it");
}

Status CheckOut(const fs::path& out) {
  std::error_code error;
  const fs::path part = Beside(out, kNew);
  const bool good = !fs::exists(out, error) ||
                    (fs::is_directory(out, error) &&
                     (fs::is_empty(out, error) || IsModelFolder(out)));
  if (!good || error) {
    return BadInputError(out.string() +
                         ": exists and is not a model folder; name another");
  }
  if (fs::exists(part, error) && !IsLeftover(part)) return InTheWay(part);
  const fs::path old = Beside(out, kReplaced);
  // Without `out` there is nothing to move there.
  if (fs::exists(out, error) && fs::exists(old, error) && !IsLeftover(old) &&
      !IsModelFolder(old)) {
    return InTheWay(old);
  }
  return Status();
}

// Removes what an export that was stopped has left, which CheckOut has looked
// at. Where `out` is missing, OUT.replaced.part is the model that it was to
// replace, and stays.
Status RemoveLeftovers(const fs::path& out) {
  std::error_code error;
  fs::remove_all(Beside(out, kNew), error);
  if (!error && fs::exists(out, error)) {
    fs::remove_all(Beside(out, kReplaced), error);
  }
  if (!error) return Status();
  return InternalError(
      out.string() + ": cannot remove what an earlier export left beside it: " +
      error.message());
}

Status WriteTokenTable(const ClipCheckpoint& checkpoint, const fs::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<float> vectors,
                          checkpoint.TokenVectors());
  ByteWriter writer;
  writer.PutBytes("FREEGSTT");
  writer.Put<uint32_t>(1);  // Version.
  writer.Put<uint32_t>(1);  // Half precision.
  writer.Put<uint32_t>(checkpoint.architecture().vocab_size);
  writer.Put<uint32_t>(checkpoint.architecture().text.width);
  std::vector<uint16_t> halves(vectors.size());
  for (size_t i = 0; i < vectors.size(); ++i) {
    const Eigen::half half(vectors[i]);
    if (!Eigen::numext::isfinite(half)) {
      return MissingDependencyError(
          checkpoint.path().string() +
          ": a token vector is too large for half precision");
    }
    halves[i] = Eigen::numext::bit_cast<uint16_t>(half);
  }
  writer.PutArray(halves.data(), halves.size());
  return WriteFileAtomic(path, writer.content());
}

// Copies the merges when they make as many tokens as the weights have.
Status WriteVocabulary(const ClipCheckpoint& checkpoint,
                       const fs::path& merges,
                       const fs::path& path) {
  const StatusOr<BytePairTokenizer> tokenizer = BytePairTokenizer::Load(merges);
  if (!tokenizer.ok()) {
    return MissingDependencyError(
        tokenizer.status().message() +
        "; the byte-pair merges (merges.txt) belong to the model: get those, "
        "or name them with --merges");
  }
  const int vocab_size = checkpoint.architecture().vocab_size;
  if (tokenizer->vocab_size() != vocab_size) {
    return MissingDependencyError(merges.string() + ": makes " +
                                  std::to_string(tokenizer->vocab_size()) +
                                  " tokens, but " + checkpoint.path().string() +
                                  " has " + std::to_string(vocab_size) +
                                  "; give the merges that belong to the model");
  }
  FREEGS_ASSIGN_OR_RETURN(const std::string content, ReadFile(merges));
  return WriteFileAtomic(path, content);
}

// What model.json says of the network; without the files.
json Describe(const ClipCheckpoint& checkpoint, const std::string& hash) {
  const ClipArchitecture& a = checkpoint.architecture();
  return {{"format", "FreeGS CLIP"},
          {"version", 1},
          {"name",
           "CLIP ViT " + std::to_string(a.visual.width) + "x" +
               std::to_string(a.visual.layers) + " patch " +
               std::to_string(a.patch)},
          {"licence", "that of the checkpoint; OpenAI's weights are MIT"},
          {"origin",
           ValidUtf8(checkpoint.path().filename().string()) + ", XXH3 " + hash},
          {"embedding_dim", a.embedding_dim},
          {"image_size", a.image_size},
          {"mean", a.mean},
          {"std", a.std},
          {"context_length", a.text.positions},
          {"text_width", a.text.width},
          {"vocab_size", a.vocab_size}};
}

Status Stopped(const CancellationToken* cancellation) {
  if (IsCancelled(cancellation)) {
    return InterruptedError("model: stopped");
  }
  return Status();
}

// Writes all files of the model into a folder that exists.
StatusOr<ModelInfo> WriteFiles(const ClipExportOptions& options,
                               const ClipCheckpoint& checkpoint,
                               const fs::path& folder,
                               const CancellationToken* cancellation) {
  const ClipArchitecture& a = checkpoint.architecture();
  const fs::path beside = checkpoint.path().parent_path() / "merges.txt";
  FREEGS_RETURN_IF_ERROR(
      WriteVocabulary(checkpoint,
                      options.merges.empty() ? beside : options.merges,
                      folder / "vocab"));
  FREEGS_RETURN_IF_ERROR(
      WriteTokenTable(checkpoint, folder / "text_embedding"));
  std::vector<std::string> names = {"vocab", "text_embedding"};
  const auto write = [&](const std::string& name,
                         StatusOr<OnnxGraph> graph) -> Status {
    if (!graph.ok()) return graph.status();
    names.push_back(name);
    FREEGS_RETURN_IF_ERROR(graph->Write(folder / name));
    return Stopped(cancellation);
  };
  FREEGS_RETURN_IF_ERROR(write("text.onnx", TextNetwork(checkpoint)));
  FREEGS_RETURN_IF_ERROR(
      write("visual.onnx", ImageNetwork(checkpoint, a.image_size, false)));
  std::vector<int> sizes = {a.image_size};
  if (options.dense_size != 0 && options.dense_size != a.image_size) {
    sizes.push_back(options.dense_size);
  }
  json dense = json::array();
  for (const int size : sizes) {
    const std::string name =
        dense.empty() ? "dense.onnx" : "dense" + std::to_string(size) + ".onnx";
    FREEGS_RETURN_IF_ERROR(write(name, ImageNetwork(checkpoint, size, true)));
    dense.push_back(
        {{"file", name}, {"image_size", size}, {"grid", size / a.patch}});
  }

  FREEGS_ASSIGN_OR_RETURN(const std::string hash, HashFile(checkpoint.path()));
  json info = Describe(checkpoint, hash);
  info["dense"] = std::move(dense);
  for (const std::string& name : names) {
    std::error_code error;
    FREEGS_ASSIGN_OR_RETURN(const std::string file_hash,
                            HashFile(folder / name));
    info["files"][name] = {{"bytes", fs::file_size(folder / name, error)},
                           {"hash", file_hash}};
  }
  const std::string text = JsonText(info);
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(folder / "model.json", text));
  return ParseModelInfo(text);
}

// Puts `part` in the place of `out`.
Status Replace(const fs::path& part, const fs::path& out) {
  std::error_code error;
  const fs::path old = Beside(out, kReplaced);
  const bool replaces = fs::exists(out, error);
  if (replaces) fs::rename(out, old, error);
  if (!error) {
    fs::rename(part, out, error);
    std::error_code ignored;
    if (error && replaces) fs::rename(old, out, ignored);
  }
  if (error) {
    return InternalError(out.string() +
                         ": cannot be replaced: " + error.message());
  }
  if (replaces) fs::remove_all(old, error);
  return Status();
}

}  // namespace

Status ClipExportOptions::Check() const {
  if (dense_size != 0 && (dense_size < 8 || dense_size > kMaxDenseSize)) {
    return InvalidArgumentError("the dense size must lie within 8 .. " +
                                std::to_string(kMaxDenseSize) + ", or be 0");
  }
  return Status();
}

StatusOr<ModelInfo> ExportClip(const ClipExportOptions& options,
                               const fs::path& out,
                               const CancellationToken* cancellation) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  fs::path folder = out.lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();
  FREEGS_RETURN_IF_ERROR(CheckOut(folder));
  // What is read must not go when the folder is replaced.
  for (const fs::path& input : {options.checkpoint, options.merges}) {
    if (!IsWithin(input, folder)) continue;
    return BadInputError(folder.string() + ": holds " + input.string() +
                         ", from which the model is made; name another");
  }
  FREEGS_ASSIGN_OR_RETURN(const ClipCheckpoint checkpoint,
                          ClipCheckpoint::Open(options.checkpoint));
  const int patch = checkpoint.architecture().patch;
  if (options.dense_size % patch != 0) {
    return InvalidArgumentError("the dense size " +
                                std::to_string(options.dense_size) +
                                " is not a multiple of the model's patch of " +
                                std::to_string(patch) + " pixels");
  }
  const fs::path part = Beside(folder, kNew);
  FREEGS_RETURN_IF_ERROR(RemoveLeftovers(folder));
  FREEGS_RETURN_IF_ERROR(CreateFolders(part));
  StatusOr<ModelInfo> info =
      WriteFiles(options, checkpoint, part, cancellation);
  const Status status =
      info.ok() ? Replace(part, folder) : Status(info.status());
  if (!status.ok()) {
    std::error_code error;
    fs::remove_all(part, error);
    return status;
  }
  return info;
}

}  // namespace freegs::semantics
