// SPDX-License-Identifier: BSD-3-Clause
// Camera files, the truth that `eval` reads in the layouts of data sets, and
// the suites of `bench`.

#include "core/io/image_io.h"
#include "sfm/scene/model_io.h"
#include "stages/datasets/lerf_mask.h"
#include "stages/datasets/scannet.h"
#include "stages/datasets/scannet_mesh.h"
#include "stages/datasets/three_d_ovs.h"
#include "stages/evaluation/ground_truth.h"
#include "stages/evaluation/true_masks.h"
#include "stages/scene/camera_file.h"
#include "stages/suite/suite_cells.h"
#include "tests/fuzz/reader.h"

namespace freegs::fuzz {
namespace {

namespace fs = std::filesystem;

const std::string kMesh =
    "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\n"
    "property float y\nproperty float z\nproperty ushort label\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0 9\n1 2 0 9\n1 1 3 9\n5 5 5 9\n6 7 8 9\n-9 -9 -9 9\n3 0 1 2\n";

std::string BinaryMesh() {
  ByteWriter writer;
  writer.PutBytes(
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty ushort label\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n");
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) writer.Put(static_cast<float>(i + k));
    writer.Put<uint8_t>(1);
    writer.Put<uint16_t>(5);
  }
  writer.Put<uint8_t>(3);
  for (const int32_t corner : {0, 1, 2}) writer.Put(corner);
  return std::move(writer).content();
}

std::vector<FolderFile> ScannetFiles() {
  return {{"s_vh_clean_2.ply", kMesh},
          {"s_vh_clean_2.0.010000.segs.json",
           R"({"segIndices": [4, 4, 8, 15, 15, 16]})"},
          {"s.aggregation.json",
           R"({"segGroups": [{"objectId": 1, "label": "table",
"segments": [15]}, {"objectId": 0, "label": "chair", "segments": [4, 8]}]})"},
          {"s.txt", "axisAlignment = 0 -1 0 10 1 0 0 0 0 0 1 0 0 0 0 1\n"},
          {"pose/0.txt", "1 0 0 2\n0 1 0 3\n0 0 1 4\n0 0 0 1\n"}};
}

std::string MaskBytes() {
  const fs::path path = Scratch() / "mask.png";
  Require(WriteImage(path, ImageU8(8, 6, 1, 255)).ok());
  return ReadText(path);
}

// A scene of two photographs with COLMAP's poses.
std::vector<FolderFile> ModelFiles() {
  sfm::Reconstruction scene;
  scene.cameras = {{1, sfm::CameraModel::kSimpleRadial, 8, 6, {9, 4, 3, 0.1}}};
  for (uint32_t id = 1; id <= 2; ++id) {
    sfm::PosedImage image;
    image.id = id;
    image.camera_id = 1;
    image.name = std::to_string(id) + ".jpg";
    scene.images.push_back(image);
  }
  const fs::path folder = Scratch() / "seed_model";
  Require(sfm::WriteModel(folder, scene, sfm::ModelFormat::kText).ok());
  std::vector<FolderFile> files;
  for (const char* name : {"cameras.txt", "images.txt", "points3D.txt"}) {
    files.push_back({std::string("sparse/0/") + name, ReadText(folder / name)});
  }
  return files;
}

std::vector<FolderFile> LerfMaskFiles() {
  std::vector<FolderFile> files = ModelFiles();
  files.push_back({"images/1.jpg", ""});
  files.push_back({"images/2.jpg", ""});
  files.push_back({"images_train/1.jpg", ""});
  files.push_back({"test_mask/2/red apple.png", MaskBytes()});
  return files;
}

std::vector<FolderFile> ThreeDOvsFiles() {
  std::vector<FolderFile> files = ModelFiles();
  files.push_back({"images/1.jpg", ""});
  files.push_back({"segmentations/classes.txt", "red apple\nbanana\n"});
  files.push_back({"segmentations/01/red_apple.png", MaskBytes()});
  return files;
}

// The masks of every test view, as `eval` reads them.
void ReadMasks(const StatusOr<stages::GroundTruth>& truth) {
  if (!truth.ok()) return;
  ThreadPool pool(1);
  for (const View& view : truth->cameras.test) {
    (void)stages::ReadTrueMasks(*truth, view, pool);
  }
}

}  // namespace

Reader CameraFile() {
  return {[](std::string_view bytes) {
            (void)stages::ParseCameraSet(bytes, "cameras.json");
          },
          [] {
            return std::vector<std::string>{
                R"({"intrinsics": {"w": 64, "h": 48, "fx": 60, "fy": 61,
"cx": 32, "cy": 24}, "train": {"a.jpg": [[1,0,0,0],[0,1,0,0],[0,0,1,5],
[0,0,0,1]]}, "test": {"b.jpg": [[1,0,0,0],[0,0,-1,0],[0,1,0,5]]}})"};
          }};
}

Reader ObjectFile() {
  return {[](std::string_view bytes) {
            (void)stages::ParseTrueObjects(bytes, "objects.json");
          },
          [] {
            return std::vector<std::string>{
                R"({"objects": [{"id": 1, "label": "red apple", "aabb":
{"min": [0, 0, 0], "max": [1, 1, 1]}, "obb": {"center": [0, 0, 0],
"size": [1, 1, 1], "rotation": [[1,0,0],[0,1,0],[0,0,1]]}}]})"};
          }};
}

Reader ScannetMeshFile() {
  return {[](std::string_view bytes) {
            const auto mesh = stages::ParseScannetMesh(bytes, "mesh.ply");
            if (!mesh.ok()) return;
            for (const auto& triangle : mesh->triangles) {
              for (const uint32_t corner : triangle) {
                Require(corner < mesh->vertices.size());
              }
            }
            (void)stages::FindPieces(*mesh);
          },
          [] {
            return std::vector<std::string>{kMesh, BinaryMesh()};
          }};
}

Reader Scannet() {
  return {[](std::string_view bytes) {
            static const std::vector<FolderFile> files = ScannetFiles();
            WriteWithOneReplaced(Scratch() / "scan", files, bytes);
            (void)stages::ReadScannet(Scratch() / "scan");
          },
          [] { return SeedsOfFolder(ScannetFiles()); }};
}

Reader LerfMask() {
  return {[](std::string_view bytes) {
            static const std::vector<FolderFile> files = LerfMaskFiles();
            WriteWithOneReplaced(Scratch() / "lerf", files, bytes);
            ReadMasks(stages::ReadLerfMask(Scratch() / "lerf"));
          },
          [] { return SeedsOfFolder(LerfMaskFiles()); }};
}

Reader SuiteFile() {
  return {[](std::string_view bytes) {
            const auto suite =
                stages::ParseSuite(std::string(bytes), "/suites/s.ini");
            if (!suite.ok()) return;
            const auto cells = stages::MakeCells(*suite, {});
            if (cells.ok()) Require(!cells->empty() && cells->size() <= 10000);
          },
          [] {
            return std::vector<std::string>{
                "[suite]\ntitle = T\nseeds = 1 2\nto = sfm\nlimit = 60\n"
                "[scene a]\nimages = p\ntruth = q\nsfm.import = ${scene}/m\n"
                "[scene b]\ndraw = --views 3\n[grid g]\npreset = fast\n"
                "reconstruct.iterations = 10 \"20\"\n[chart c]\nx = a\n"
                "y = b\nlog_x = true\ngrids = g\n[table t]\ncolumns = a b\n"
                "mean of all = a b\n"};
          }};
}

Reader ThreeDOvs() {
  return {[](std::string_view bytes) {
            static const std::vector<FolderFile> files = ThreeDOvsFiles();
            WriteWithOneReplaced(Scratch() / "3dovs", files, bytes);
            ReadMasks(stages::ReadThreeDOvs(Scratch() / "3dovs"));
          },
          [] { return SeedsOfFolder(ThreeDOvsFiles()); }};
}

}  // namespace freegs::fuzz
