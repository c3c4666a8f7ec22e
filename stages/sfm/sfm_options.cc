// SPDX-License-Identifier: BSD-3-Clause
// The options of stage sfm: names, help texts and ranges.

#include <string>
#include <vector>

#include "pipeline/option_table.h"
#include "sfm/scene/camera_model.h"
#include "stages/sfm/sfm_stage.h"

namespace freegs::stages {
namespace {

// Which pairs of photos are matched.
void RegisterPairOptions(SfmStageOptions& options,
                         pipeline::OptionTable& table) {
  auto& pairs = options.colmap.pairs;
  table.Add(
      "sfm.matcher",
      &pairs.matcher,
      {.help = "Pairs of photos to match: exhaustive (all), retrieval (each "
               "photo with those most alike), sequential (these, and "
               "five neighbours on each side in name order), or auto: "
               "exhaustive up to 40 photos, then retrieval, with neighbours "
               "where numbered photos prove to be in order.",
       .choices = {"auto", "exhaustive", "sequential", "retrieval"}});
  table.Add("sfm.neighbours",
            &pairs.num_neighbours,
            {.help = "Retrieval: photos most alike that each is matched with. "
                     "Matching time grows in proportion.",
             .min = 1,
             .max = 10000});
}

}  // namespace

void RegisterSfmOptions(SfmStageOptions& options,
                        pipeline::OptionTable& table) {
  std::vector<std::string> models = {"auto"};
  for (const sfm::CameraModelInfo& model : sfm::CameraModels()) {
    models.emplace_back(model.name);
  }
  table.AddSection("sfm", "Camera poses and points from the photos (COLMAP).");
  table.Add("sfm.import",
            &options.import,
            {.help = "Take poses from here instead of running COLMAP: a COLMAP "
                     "model folder, or a transforms.json of nerfstudio, "
                     "instant-ngp or NeRF-synthetic.",
             .is_path = true});
  table.Add("sfm.random_points",
            &options.random_points,
            {.help = "Random start points when an import has none. 0: the "
                     "points that the photos show from the imported poses, or "
                     "10000 random ones if these are few.",
             .min = 0,
             .max = 1e7});
  table.Add("sfm.colmap",
            &options.colmap.colmap,
            {.help = "The COLMAP program: a path, or a name in PATH.",
             .value_name = "PROGRAM",
             .affects_result = false,
             .is_program = true});
  table.Add("sfm.camera",
            &options.colmap.camera,
            {.help = "Photos that share intrinsics: auto (same size, camera "
                     "and focal length), single (same size), or per_image.",
             .choices = {"auto", "single", "per_image"}});
  table.Add("sfm.camera_model",
            &options.colmap.camera_model,
            {.help = "Lens model to estimate; auto: the simplest that explains "
                     "the matches, with as few cameras.",
             .choices = models});
  table.Add("sfm.max_image_size",
            &options.colmap.max_image_size,
            {.help = "Longest side in pixels of the images that features are "
                     "taken from. 0: the smallest from 800 to 1600 that is "
                     "enough for sfm.max_features.",
             .min = 0,
             .max = 100000,
             .accepts =
                 [](const std::string& text) {
                   const int side = std::stoi(text);
                   return side == 0 || side >= 64;
                 },
             .allowed = "0 or 64 .. 100000"});
  table.Add("sfm.max_features",
            &options.colmap.max_features,
            {.help = "Features per photo, the largest ones. More connect more "
                     "photos; matching time grows with the square. Of fewer "
                     "than 20 photos 8/3 times as many, at most 8000.",
             .min = 64,
             .max = 100000});
  RegisterPairOptions(options, table);
  table.Add(
      "sfm.min_registered_share",
      &options.health.min_registered_share,
      {.help = "Share of photos that must get a pose.", .min = 0, .max = 1});
}

}  // namespace freegs::stages
