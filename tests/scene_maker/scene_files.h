// SPDX-License-Identifier: BSD-3-Clause
// Writes a scene as a folder of photographs with their truth.

#ifndef FREEGS_TESTS_SCENE_MAKER_SCENE_FILES_H_
#define FREEGS_TESTS_SCENE_MAKER_SCENE_FILES_H_

#include <filesystem>
#include <functional>
#include <string>

#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"
#include "tests/scene_maker/scene.h"

namespace freegs::scene_maker {

// Draws every view and writes
//   images/frame_0001.jpg ...                 photographs
//   test/images/test_01.png ...               photographs for evaluation
//   test/masks/<view>/<label>.png             objects with >= 30 pixels, 0/255
//   test/masks_background/<view>/<class>.png  table, floor, wall
//   gt/cameras.json                           intrinsics, world_to_camera
//   gt/transforms.json                        training cameras for --sfm.import
//   gt/objects.json                           labels and boxes
//   gt/instance/<view>.png                    8-bit object ids, train and test
//   gt/surfaces/<view>.png                    of clutter and furniture: 8-bit
//                                             object ids, and 200 + number of a
//                                             surface
//   gt/depth/<test view>.npz                  key depth, float16 metres
//   README.md
// Calls progress(done, total) after each view, if given. Fails with kBadInput
// where the folder has images or README.md already.
Status WriteScene(const Scene& scene,
                  const std::filesystem::path& folder,
                  ThreadPool& pool,
                  const std::function<void(int, int)>& progress = {});

// The bytes of a NumPy .npz archive (a zip file, stored) with one float16 array
// of shape (height, width).
std::string EncodeNpzFloat16(const std::string& key, const ImageF& values);

}  // namespace freegs::scene_maker

#endif  // FREEGS_TESTS_SCENE_MAKER_SCENE_FILES_H_
