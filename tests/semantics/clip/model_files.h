// SPDX-License-Identifier: BSD-3-Clause
// A small model folder of random numbers with what PyTorch makes of it, and
// ways to break it.

#ifndef FREEGS_TESTS_SEMANTICS_CLIP_MODEL_FILES_H_
#define FREEGS_TESTS_SEMANTICS_CLIP_MODEL_FILES_H_

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "tests/temporary_folder.h"

namespace freegs::semantics {

// Made by scripts/export_clip.py and scripts/check_clip_export.py with
//   --random ViT-B/16 --seed 1 --image-size 16 --patch 8 --width 16 --layers 2
//   --heads 2 --embedding-dim 8 --text-width 16 --text-layers 1 --text-heads 2
// and the merges in its file vocab; one more dense network of 32 pixels.
inline std::filesystem::path TinyClip() {
  return std::filesystem::path(FREEGS_SOURCE_DIR) /
         "tests/semantics/clip/data/tiny_clip";
}

// A copy of that folder that a test may damage.
class ModelCopy {
 public:
  ModelCopy() { std::filesystem::copy(TinyClip(), path()); }

  std::filesystem::path path() const { return folder_ / "model"; }

  nlohmann::json Info() const {
    return nlohmann::json::parse(ReadText(path() / "model.json"));
  }
  void SetInfo(const nlohmann::json& info) const {
    WriteText(path() / "model.json", info.dump());
  }

  // As a model that brings its upsampler; see data/make_upsampler.py.
  void AddUpsampler() const {
    Replace("upsampler.onnx",
            ReadText(TinyClip().parent_path() / "upsampler.onnx"));
    nlohmann::json info = Info();
    info["upsampled_size"] = 16;
    SetInfo(info);
  }

  // Replaces a file and enters it in model.json, as if it belonged there.
  void Replace(const std::string& name, const std::string& content) const {
    WriteText(path() / name, content);
    nlohmann::json info = Info();
    info["files"][name] = {{"bytes", content.size()},
                           {"hash", HashBytes(content)}};
    SetInfo(info);
  }

 private:
  TemporaryFolder folder_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_TESTS_SEMANTICS_CLIP_MODEL_FILES_H_
