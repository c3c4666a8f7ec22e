// SPDX-License-Identifier: BSD-3-Clause

#include "bench/evidence/learning_scene.h"

#include <algorithm>

#include "core/io/image_io.h"
#include "semantics/field/idsf.h"
#include "semantics/geometry/scene_extent.h"
#include "semantics/patches/patch_graph.h"
#include "semantics/patches/scene_patches.h"
#include "splat/weights/blending_weights.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::evidence {
namespace {

namespace fs = std::filesystem;

constexpr double kMinOpacity = 0.1;
constexpr size_t kMaxPictures = 3;
// A region is of a true segment if this share of its pixels is.
constexpr double kPure = 0.65;

// The true segments of a view: (number, mask).
using Masks = std::vector<std::pair<int, ImageU8>>;

StatusOr<Masks> SplitIds(const fs::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const ImageU16 ids, ReadLabels(path));
  std::map<int, ImageU8> by_id;
  for (size_t i = 0; i < ids.size(); ++i) {
    const int id = ids.data()[i];
    if (id == 0) continue;
    auto [it, added] = by_id.try_emplace(id);
    if (added) it->second = ImageU8(ids.width(), ids.height(), 1);
    it->second.data()[i] = 255;
  }
  Masks masks;
  for (auto& [id, mask] : by_id) masks.emplace_back(id, std::move(mask));
  return masks;
}

StatusOr<Masks> ReadMasks(const fs::path& truth,
                          const std::string& name,
                          std::map<std::string, int>* numbers) {
  const std::string stem = fs::path(name).stem();
  for (const char* folder : {"gt/surfaces", "gt/instance"}) {
    const fs::path drawn = truth / folder / (stem + ".png");
    if (fs::exists(drawn)) return SplitIds(drawn);
  }
  Masks masks;
  const fs::path folder = truth / "test_mask" / stem;
  if (!fs::exists(folder)) return masks;
  for (const auto& entry : fs::directory_iterator(folder)) {
    FREEGS_ASSIGN_OR_RETURN(const ImageU16 read, ReadLabels(entry.path()));
    ImageU8 mask(read.width(), read.height(), 1);
    for (size_t i = 0; i < read.size(); ++i) {
      mask.data()[i] = read.data()[i] > 0 ? 255 : 0;
    }
    const int number = numbers
                           ->try_emplace(entry.path().stem().string(),
                                         static_cast<int>(numbers->size()) + 1)
                           .first->second;
    masks.emplace_back(number, std::move(mask));
  }
  return masks;
}

void CountVotes(const Image<int32_t>& patches,
                const Masks& masks,
                LearningScene* scene) {
  const int width = patches.width();
  const int height = patches.height();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int32_t patch = patches(x, y);
      if (patch >= 0) scene->pixels[patch] += 1;
      for (const auto& [id, mask] : masks) {
        if (mask((2 * x + 1) * mask.width() / (2 * width),
                 (2 * y + 1) * mask.height() / (2 * height)) <= 127) {
          continue;
        }
        scene->segment_pixels[id] += 1;
        if (patch >= 0) scene->votes[patch][id] += 1;
      }
    }
  }
}

// The name of the workspace's folder, also where the path ends in a slash.
std::string SceneName(const fs::path& workspace) {
  const fs::path path = workspace.lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename();
}

}  // namespace

int TrueSegment(const std::map<int, double>& votes, double pixels) {
  for (const auto& [id, count] : votes) {
    if (pixels > 0 && count >= kPure * pixels) return id;
  }
  return -1;
}

std::map<int, double> SumOfVotes(std::map<int, double> votes,
                                 const std::map<int, double>& others) {
  for (const auto& [id, count] : others) votes[id] += count;
  return votes;
}

StatusOr<std::vector<LearningScene>> LoadLearningScene(
    const fs::path& workspace,
    const fs::path& truth,
    bool with_semantics,
    ThreadPool& pool) {
  FREEGS_ASSIGN_OR_RETURN(const stages::WorkspaceScene scene,
                          stages::ReadWorkspaceScene(workspace));
  std::vector<View> views = scene.train;
  views.insert(views.end(), scene.holdout.begin(), scene.holdout.end());
  const auto photo_of = [&](size_t v) {
    return ReadRgb(workspace / "undistort/images" / scene.train[v].name);
  };
  FREEGS_ASSIGN_OR_RETURN(
      std::vector<semantics::ScenePatches> divisions,
      semantics::BuildScenePatches(
          {.model = scene.model,
           .views = scene.train,
           .render = scene.render,
           .photo_of = photo_of,
           .scene_radius = semantics::ComputeSceneExtent(
                               scene.model, views, kMinOpacity, pool)
                               .radius},
          pool,
          nullptr));
  if (with_semantics) {
    FREEGS_ASSIGN_OR_RETURN(
        const semantics::Idsf field,
        semantics::ReadIdsf(workspace / "bootstrap/idsf.bin"));
    if (field.features.empty() ||
        field.instances.size() != scene.model.size()) {
      return BadInputError(workspace.string() +
                           ": bootstrap has no semantics for these Gaussians");
    }
    for (semantics::ScenePatches& patches : divisions) {
      semantics::SetSemantics(field.features, field.feature_dim, &patches);
    }
  }
  std::vector<LearningScene> result;
  for (semantics::ScenePatches& patches : divisions) {
    LearningScene& one = result.emplace_back();
    one.name = SceneName(workspace);
    one.patches = std::move(patches);
    one.votes.resize(one.patches.graph.regions.size());
    one.pixels.assign(one.patches.graph.regions.size(), 0);
  }
  std::map<std::string, int> numbers;
  for (View view : views) {
    FREEGS_ASSIGN_OR_RETURN(const Masks masks,
                            ReadMasks(truth, view.name, &numbers));
    if (masks.empty()) continue;
    view.camera = view.camera.LimitedTo(semantics::kPatchImageSide);
    FREEGS_ASSIGN_OR_RETURN(
        const splat::BlendingWeights weights,
        splat::ComputeBlendingWeights(
            scene.model, view.camera, view.cam_from_world, scene.render, pool));
    for (LearningScene& one : result) {
      Image<int32_t> shown = semantics::PatchOfPixels(
          weights.matrix(), one.patches.patch_of_gaussian);
      CountVotes(shown, masks, &one);
      if (one.pictures.size() < kMaxPictures) {
        one.pictures.emplace_back(fs::path(view.name).stem(), std::move(shown));
      }
    }
  }
  if (result[0].segment_pixels.empty()) {
    return BadInputError(truth.string() + ": no true masks of the photos of " +
                         workspace.string());
  }
  return result;
}

}  // namespace freegs::evidence
