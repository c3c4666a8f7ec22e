// SPDX-License-Identifier: BSD-3-Clause

#include "stages/query/query_masks.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/json_text.h"
#include "splat/render/renderer.h"
#include "stages/scene/scene_instances.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// At most so many views get an overlay, evenly spread over those that see an
// instance of the answer.
constexpr size_t kMaxOverlays = 6;

// Writes pictures, and removes them again when the answer was not finished:
// query.json, which lists them, is written at the end.
class PictureFolder {
 public:
  ~PictureFolder() {
    std::error_code error;
    for (const fs::path& path : written_) fs::remove(path, error);
  }

  Status Write(const fs::path& path, const ImageU8& image) {
    FREEGS_RETURN_IF_ERROR(CreateFolders(path.parent_path()));
    written_.push_back(path);
    return WriteImage(path, image);
  }

  void Keep() { written_.clear(); }

 private:
  std::vector<fs::path> written_;
};

// 255 where one of the instances has the largest weight.
ImageU8 MaskOf(const QueryMasksTask& task, const View& view, ThreadPool& pool) {
  ImageU8 mask(view.camera.width, view.camera.height, 1);
  if (task.ids.empty()) return mask;
  const Image<int32_t> labels =
      RenderLabels(task.scene, view, task.labels, pool);
  std::transform(labels.data(),
                 labels.data() + labels.size(),
                 mask.data(),
                 [&task](int32_t label) {
                   const bool asked =
                       label >= 0 &&
                       std::find(task.ids.begin(), task.ids.end(), label + 1) !=
                           task.ids.end();
                   return asked ? uint8_t{255} : uint8_t{0};
                 });
  return mask;
}

StatusOr<ImageU8> PictureOf(const QueryMasksTask& task,
                            const View& view,
                            ThreadPool& pool) {
  if (task.photos.empty()) {
    return ToU8(splat::RenderView(task.scene.model,
                                  view.camera,
                                  view.cam_from_world,
                                  task.scene.render,
                                  pool)
                    .color);
  }
  FREEGS_ASSIGN_OR_RETURN(ImageU8 photo, ReadRgb(task.photos / view.name));
  if (photo.width() == view.camera.width &&
      photo.height() == view.camera.height) {
    return photo;
  }
  return Resize(photo, view.camera.width, view.camera.height);
}

// Writes overlays for some of the views whose mask is not empty.
Status WriteOverlays(const QueryMasksTask& task,
                     const std::vector<MaskedView>& masks,
                     ThreadPool& pool,
                     PictureFolder* folder) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                          OutputNames(task.views, ".jpg"));
  std::vector<size_t> seeing;
  for (size_t i = 0; i < masks.size(); ++i) {
    if (masks[i].pixels > 0) seeing.push_back(i);
  }
  const size_t count = std::min(seeing.size(), kMaxOverlays);
  for (size_t k = 0; k < count; ++k) {
    const size_t i = seeing[k * seeing.size() / count];
    FREEGS_ASSIGN_OR_RETURN(const ImageU16 mask,
                            ReadLabels(task.out / masks[i].mask));
    FREEGS_ASSIGN_OR_RETURN(const ImageU8 picture,
                            PictureOf(task, task.views[i], pool));
    Image<int32_t> labels(mask.width(), mask.height(), 1, -1);
    for (size_t p = 0; p < mask.size(); ++p) {
      if (mask.data()[p] != 0) labels.data()[p] = task.ids[0] - 1;
    }
    FREEGS_RETURN_IF_ERROR(folder->Write(task.out / "overlay" / names[i],
                                         OverlayInstances(picture, labels)));
  }
  return Status();
}

}  // namespace

void RemoveEarlierAnswer(const fs::path& out) {
  const StatusOr<nlohmann::json> answer = ReadJson(out / "query.json");
  if (!answer.ok() || !answer->is_object()) return;
  std::error_code error;
  for (const nlohmann::json& view : answer->value("masks", nlohmann::json())) {
    if (!view.is_object() || !view.contains("mask")) continue;
    const nlohmann::json& mask = view["mask"];
    if (!mask.is_string()) continue;
    const auto& file = mask.get_ref<const std::string&>();
    constexpr std::string_view kFolder = "masks/";
    // Somebody else may have written the list.
    if (!file.starts_with(kFolder) || !file.ends_with(".png") ||
        !IsNameBelowFolder(file)) {
      continue;
    }
    fs::remove(out / file, error);
    const fs::path name = file.substr(kFolder.size());
    fs::remove(out / "overlay" / fs::path(name).replace_extension(".jpg"),
               error);
  }
  fs::remove(out / "query.json", error);
}

StatusOr<std::vector<MaskedView>> WriteQueryMasks(
    const QueryMasksTask& task,
    const CancellationToken& cancellation,
    FunctionRef<void(size_t)> progress,
    ThreadPool& pool) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                          OutputNames(task.views, ".png"));
  PictureFolder folder;
  std::vector<MaskedView> masks;
  for (size_t i = 0; i < task.views.size(); ++i) {
    if (cancellation.cancelled()) {
      return InterruptedError("query: stopped after " + std::to_string(i) +
                              " of " + std::to_string(task.views.size()) +
                              " masks");
    }
    const ImageU8 mask = MaskOf(task, task.views[i], pool);
    const std::string file = "masks/" + names[i];
    FREEGS_RETURN_IF_ERROR(folder.Write(task.out / file, mask));
    masks.push_back(
        {task.views[i].name,
         file,
         std::count(mask.data(), mask.data() + mask.size(), uint8_t{255})});
    progress(i + 1);
  }
  FREEGS_RETURN_IF_ERROR(WriteOverlays(task, masks, pool, &folder));
  folder.Keep();
  return masks;
}

}  // namespace freegs::stages
