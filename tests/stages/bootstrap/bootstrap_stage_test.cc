// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bootstrap/bootstrap_stage.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "photos/photo_list.h"
#include "semantics/field/idsf.h"
#include "semantics/instances/instances_json.h"
#include "semantics/queries/instance_features.h"
#include "sfm/scene/model_io.h"
#include "splat/render/renderer.h"
#include "splat/scene/ply_io.h"
#include "stages/bootstrap/seen_photo.h"
#include "stages/scene/clip_input.h"
#include "tests/semantics/clip/model_files.h"
#include "tests/semantics/synthetic_gaussians.h"
#include "tests/stages/moved_world.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

int MaxDifference(const ImageU8& a, const ImageU8& b) {
  int largest = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, std::abs(a.data()[i] - b.data()[i]));
  }
  return largest;
}

// A workspace as reconstruct leaves it: a table with four balls, seen by eight
// cameras that look down on it from all around.
class BootstrapStageTest : public testing::Test {
 protected:
  static constexpr int kNumPhotos = 8;
  static constexpr int kWidth = 240;
  static constexpr int kHeight = 180;

  void SetUp() override {
    scene_ = semantics::MakeTableScene();
    sfm::Reconstruction sparse;
    sfm::Camera camera;
    camera.id = 1;
    camera.model = sfm::CameraModel::kPinhole;
    const Pinhole pinhole =
        semantics::LookAtOrigin(0).camera.Resized(kWidth, kHeight);
    camera.width = kWidth;
    camera.height = kHeight;
    camera.params = {pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy};
    sparse.cameras.push_back(camera);
    photos::PhotoList photos;
    ThreadPool pool(2);
    for (int k = 0; k < kNumPhotos; ++k) {
      sfm::PosedImage image;
      image.id = static_cast<uint32_t>(k + 1);
      image.camera_id = 1;
      // One in a folder of its own.
      image.name =
          (k == 3 ? "sub/photo" : "photo") + std::to_string(k) + ".png";
      image.cam_from_world = semantics::LookAtOrigin(0.785 * k).cam_from_world;
      sparse.images.push_back(image);
      const fs::path file = workspace() / "undistort" / "images" / image.name;
      fs::create_directories(file.parent_path());
      const splat::RenderedView picture =
          splat::RenderView(scene_.model,
                            pinhole,
                            image.cam_from_world,
                            splat::RenderOptions(),
                            pool);
      ASSERT_TRUE(WriteImage(file, ToU8(picture.color)).ok());
      photos::Photo photo;
      photo.file = photo.name = image.name;
      photo.width = kWidth;
      photo.height = kHeight;
      photo.camera_group = 0;
      photo.split =
          k == 0 ? photos::PhotoSplit::kHoldout : photos::PhotoSplit::kTrain;
      photos.photos.push_back(photo);
    }
    ASSERT_TRUE(
        sfm::WriteModel(workspace() / "undistort" / "sparse", sparse).ok());
    fs::create_directories(workspace() / "ingest");
    ASSERT_TRUE(
        photos::WritePhotoList(workspace() / "ingest" / "images.json", photos)
            .ok());
    fs::create_directories(workspace() / "reconstruct");
    WriteModel(scene_.model);
    options_.mode = "geometry";
  }

  void WriteModel(const splat::GaussianModel& model) {
    ASSERT_TRUE(
        splat::WritePly(workspace() / "reconstruct" / "point_cloud.ply", model)
            .ok());
  }

  Status Run(const fs::path& output,
             int threads = 2,
             const CancellationToken* cancellation = nullptr,
             bool resuming = false) {
    ThreadPool pool(threads);
    const CancellationToken never;
    pipeline::StageContext context;
    context.workspace = workspace();
    context.output = output;
    context.resuming = resuming;
    context.earlier_seconds = resuming ? 1000 : 0;
    context.earlier_cpu_seconds = resuming ? 2000 : 0;
    context.pool = &pool;
    context.cancellation = cancellation != nullptr ? cancellation : &never;
    context.progress = [](const Progress&) {};
    context.log = [this](pipeline::LogLevel, const std::string& line) {
      log_ += line + "\n";
    };
    fs::create_directories(output);
    const auto stage = MakeBootstrapStage(options_, /*seed=*/0);
    EXPECT_EQ(stage->name(), "bootstrap");
    return stage->Run(context);
  }

  const fs::path& workspace() const { return folder_.path(); }

  TemporaryFolder folder_;
  semantics::SyntheticGaussians scene_;
  BootstrapStageOptions options_;
  std::string log_;  // The log of all runs.
};

TEST_F(BootstrapStageTest, TheSceneIsSeenWhereAMaskIgnoresThePhoto) {
  const auto scene = ReadWorkspaceScene(workspace());
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  const View& view = scene->train[0];
  const fs::path file = workspace() / "undistort" / "images" / view.name;
  const ImageU8 photo = *ReadRgb(file);
  ImageU8 spoilt = photo;
  ImageU8 mask(kWidth, kHeight, 1, 255);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth / 2; ++x) {
      mask(x, y) = 0;
      for (int c = 0; c < 3; ++c) spoilt(x, y, c) = 255;
    }
  }
  ASSERT_TRUE(WriteImage(file, spoilt).ok());
  EXPECT_GT(MaxDifference(*ReadSeenPhoto(workspace(), *scene, view), photo),
            50);
  const fs::path mask_file =
      workspace() / "undistort" / "masks" / (view.name + ".png");
  fs::create_directories(mask_file.parent_path());
  ASSERT_TRUE(WriteImage(mask_file, mask).ok());
  EXPECT_LE(MaxDifference(*ReadSeenPhoto(workspace(), *scene, view), photo), 8);

  // The photo was exposed half as long as the scene.
  WorkspaceScene exposed = *scene;
  splat::AffineColor half;
  for (const size_t k : {0u, 5u, 10u}) half.values[k] = 0.5f;
  exposed.exposures = {{view.name, half}};
  const ImageU8 darker = *ReadSeenPhoto(workspace(), exposed, view);
  for (int y = 0; y < kHeight; y += 7) {
    for (int x = 0; x < kWidth / 2; x += 7) {
      ASSERT_NEAR(darker(x, y, 1), 0.5 * photo(x, y, 1), 5);
    }
  }
  EXPECT_EQ(darker(kWidth - 1, 0, 1), photo(kWidth - 1, 0, 1));
  ASSERT_TRUE(WriteImage(mask_file, ImageU8(8, 8, 1, 255)).ok());
  EXPECT_EQ(ReadSeenPhoto(workspace(), *scene, view).status().code(),
            StatusCode::kBadInput);
}

TEST_F(BootstrapStageTest, ExposuresAreAnInputWhereThereAreMasks) {
  const auto stage = MakeBootstrapStage(options_, /*seed=*/0);
  pipeline::StageContext context;
  context.workspace = workspace();
  const auto has_exposures = [&] {
    const std::vector<fs::path> inputs = stage->Inputs(context);
    return std::find(inputs.begin(),
                     inputs.end(),
                     "reconstruct/exposure.json") != inputs.end();
  };
  EXPECT_FALSE(has_exposures());
  fs::create_directories(workspace() / "undistort" / "masks");
  EXPECT_TRUE(has_exposures());
}

TEST_F(BootstrapStageTest, AModelThatIsNotUsedIsTold) {
  fs::remove(workspace() / "reconstruct" / "point_cloud.ply");
  EXPECT_FALSE(Run(workspace() / "out").ok());
  EXPECT_EQ(log_, "");
  options_.model = "models/clip";
  EXPECT_FALSE(Run(workspace() / "out").ok());
  EXPECT_NE(log_.find("bootstrap.model is not used"), std::string::npos)
      << log_;
}

TEST_F(BootstrapStageTest, WritesInstancesMapsAndPreviews) {
  const fs::path output = workspace() / "bootstrap";
  const Status status = Run(output);
  ASSERT_TRUE(status.ok()) << status.message();

  const auto idsf = semantics::ReadIdsf(output / "idsf.bin");
  ASSERT_TRUE(idsf.ok());
  EXPECT_EQ(idsf->instances.size(), scene_.model.size());
  EXPECT_EQ(idsf->feature_dim, 0);
  const auto instances = semantics::ReadInstances(output / "instances.json");
  ASSERT_TRUE(instances.ok());
  ASSERT_EQ(instances->size(), 5u);
  EXPECT_TRUE((*instances)[0].background);
  for (int i = 0; i < 5; ++i) {
    const semantics::Instance& instance = (*instances)[i];
    EXPECT_EQ(instance.id, i + 1);
    EXPECT_TRUE(instance.words.empty());
    if (i == 0) continue;
    EXPECT_LE(instance.num_gaussians, (*instances)[i - 1].num_gaussians);
    // Balls of diameter 0.3 and 0.2, boxes upright.
    EXPECT_NEAR(instance.obb.size.x(), i == 4 ? 0.2 : 0.3, 0.03);
    EXPECT_NEAR(std::abs(instance.obb.rotation(2, 2)), 1, 1e-4);
  }

  const auto text = ReadFile(output / "metrics.json");
  ASSERT_TRUE(text.ok());
  const auto metrics = nlohmann::json::parse(*text);
  EXPECT_EQ(metrics["num_instances"], 5);
  EXPECT_EQ(metrics["num_background"], 1);
  EXPECT_GT(metrics["agreement"].get<double>(), 0.5);
  EXPECT_EQ(metrics["instance_sizes"].size(), 5u);
  EXPECT_FALSE(metrics.contains("hdbscan"));

  std::set<uint16_t> ids;
  for (int k = 0; k < kNumPhotos; ++k) {
    const std::string name =
        (k == 3 ? "sub/photo" : "photo") + std::to_string(k) + ".png";
    const auto map = ReadLabels(output / "instances" / name);
    ASSERT_TRUE(map.ok()) << name;
    EXPECT_EQ(map->width(), kWidth);
    for (size_t i = 0; i < map->size(); ++i) ids.insert(map->data()[i]);
  }
  EXPECT_EQ(ids, (std::set<uint16_t>{0, 1, 2, 3, 4, 5}));
  int num_previews = 0;
  for (const auto& entry :
       fs::recursive_directory_iterator(output / "preview")) {
    num_previews += entry.is_regular_file();
  }
  EXPECT_EQ(num_previews, options_.num_previews);
}

TEST_F(BootstrapStageTest, LiftsSemantics) {
  options_.mode = "lift";
  options_.model = semantics::TinyClip().string();
  const fs::path output = workspace() / "bootstrap";
  const Status status = Run(output);
  ASSERT_TRUE(status.ok()) << status.message();
  const auto idsf = semantics::ReadIdsf(output / "idsf.bin");
  ASSERT_TRUE(idsf.ok());
  EXPECT_GT(idsf->feature_dim, 0);
  const auto instances = semantics::ReadInstances(output / "instances.json");
  const auto features =
      semantics::ReadInstanceFeatures(output / "instance_features.json");
  ASSERT_TRUE(instances.ok() && features.ok());
  EXPECT_EQ(features->size(), instances->size());
  EXPECT_EQ(features->dim, 8);
  EXPECT_EQ(features->model, semantics::TinyClip().string());
  const auto text = ReadFile(output / "metrics.json");
  ASSERT_TRUE(text.ok());
  const auto metrics = nlohmann::json::parse(*text);
  EXPECT_EQ(metrics["feature_dim"], idsf->feature_dim);
  EXPECT_TRUE(metrics["num_words_withheld"].is_number_integer());
  EXPECT_EQ(metrics["step_seconds"].size(), 4u);

  // A run that goes on from what an interrupted run has left ends the same.
  ASSERT_TRUE(Run(output, 1, nullptr, /*resuming=*/true).ok());
  EXPECT_EQ(semantics::ReadIdsf(output / "idsf.bin")->features, idsf->features);
}

TEST_F(BootstrapStageTest, AModelInTheWorkspaceIsFoundWhenThatIsMoved) {
  options_.mode = "lift";
  const fs::path model = workspace() / "clip";
  fs::copy(semantics::TinyClip(), model);
  options_.model = model.string();
  const fs::path output = workspace() / "bootstrap";
  const Status status = Run(output);
  ASSERT_TRUE(status.ok()) << status.message();
  const auto features =
      semantics::ReadInstanceFeatures(output / "instance_features.json");
  ASSERT_TRUE(features.ok());
  EXPECT_EQ(features->model, "clip");
  TemporaryFolder elsewhere;
  fs::rename(model, elsewhere / "clip");
  const auto encoder = OpenModelOfFeatures(*features, elsewhere.path(), "");
  EXPECT_TRUE(encoder.ok()) << encoder.status().message();
}

TEST_F(BootstrapStageTest, MissingModelIsAMissingDependency) {
  options_.mode = "lift";
  options_.model = (workspace() / "no_such_model").string();
  const Status status = Run(workspace() / "modelless");
  EXPECT_EQ(status.code(), StatusCode::kMissingDependency);
  EXPECT_NE(status.message().find("no_such_model"), std::string::npos);
}

TEST_F(BootstrapStageTest, SameFilesForAnyNumberOfThreads) {
  ASSERT_TRUE(Run(workspace() / "one", 1).ok());
  ASSERT_TRUE(Run(workspace() / "three", 3).ok());
  for (const char* name :
       {"idsf.bin", "instances.json", "instances/photo5.png"}) {
    const auto a = ReadFile(workspace() / "one" / name);
    const auto b = ReadFile(workspace() / "three" / name);
    ASSERT_TRUE(a.ok() && b.ok()) << name;
    EXPECT_EQ(*a, *b) << name;
  }
}

TEST_F(BootstrapStageTest, ResumesToTheSameFiles) {
  const fs::path output = workspace() / "resumed";
  ASSERT_TRUE(Run(output).ok());
  const auto map = ReadFile(output / "instances" / "photo6.png");
  fs::remove(output / "instances" / "photo6.png");
  fs::remove(output / "metrics.json");
  ASSERT_TRUE(Run(output, 2, nullptr, /*resuming=*/true).ok());
  EXPECT_EQ(*ReadFile(output / "instances" / "photo6.png"), *map);
  // The time of the first run counts.
  const auto text = ReadFile(output / "metrics.json");
  ASSERT_TRUE(text.ok());
  const auto metrics = nlohmann::json::parse(*text);
  EXPECT_GE(metrics["seconds"], 1000);
  EXPECT_GE(metrics["cpu_seconds"], 2000);
}

TEST_F(BootstrapStageTest, SameInstancesInAnyUnit) {
  RoundModel(workspace());
  ASSERT_TRUE(Run(workspace() / "plain").ok());
  const auto plain =
      semantics::ReadInstances(workspace() / "plain" / "instances.json");
  ASSERT_TRUE(plain.ok());
  const Eigen::Vector3d shift(0.05, -0.1, 0.2);
  MoveWorld(workspace(), 0.01, shift);
  const Status status = Run(workspace() / "small");
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(ReadText(workspace() / "small" / "idsf.bin"),
            ReadText(workspace() / "plain" / "idsf.bin"));
  const auto small =
      semantics::ReadInstances(workspace() / "small" / "instances.json");
  ASSERT_TRUE(small.ok());
  ASSERT_EQ(small->size(), plain->size());
  for (size_t i = 0; i < small->size(); ++i) {
    const semantics::Instance& a = (*small)[i];
    const semantics::Instance& b = (*plain)[i];
    EXPECT_NEAR((a.centre - 0.01 * b.centre - shift).norm(), 0, 1e-7);
    EXPECT_NEAR((a.aabb.max - 0.01 * b.aabb.max - shift).norm(), 0, 1e-7);
    EXPECT_NEAR((a.obb.size - 0.01 * b.obb.size).norm(), 0, 1e-7);
  }
}

TEST_F(BootstrapStageTest, RefusesAModelThatNoPhotoShows) {
  splat::GaussianModel elsewhere = scene_.model;
  for (float& x : elsewhere.means) x += 1e4f;
  WriteModel(elsewhere);
  EXPECT_EQ(Run(workspace() / "out").code(), StatusCode::kUnusableResult);
}

TEST_F(BootstrapStageTest, StopsWhenCancelled) {
  CancellationToken cancellation;
  cancellation.Cancel();
  EXPECT_EQ(Run(workspace() / "stopped", 2, &cancellation).code(),
            StatusCode::kInterrupted);
}

TEST_F(BootstrapStageTest, SaysWhatToDoWhenNothingIsFound) {
  splat::GaussianModel few = scene_.model;
  few.Resize(10);
  WriteModel(few);
  options_.clustering = "union";
  const Status status = Run(workspace() / "nothing");
  EXPECT_EQ(status.code(), StatusCode::kUnusableResult);
  EXPECT_NE(status.message().find("bootstrap.min_cluster_size"),
            std::string::npos);
}

TEST_F(BootstrapStageTest, OneOrTwoInstancesAreNotTakenForGranted) {
  ASSERT_TRUE(Run(workspace() / "good").ok());
  EXPECT_EQ(log_.find("joined"), std::string::npos) << log_;
  // Two balls and nothing else.
  std::vector<uint32_t> balls;
  for (size_t i = 0; i < scene_.truth.size(); ++i) {
    if (scene_.truth[i] == 1 || scene_.truth[i] == 2) {
      balls.push_back(static_cast<uint32_t>(i));
    }
  }
  scene_.model.Select(balls);
  WriteModel(scene_.model);
  options_.clustering = "union";
  const Status status = Run(workspace() / "few");
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_NE(log_.find("try bootstrap.clustering evidence"), std::string::npos)
      << log_;
}

TEST_F(BootstrapStageTest, MissingSceneIsBadInput) {
  fs::remove(workspace() / "reconstruct" / "point_cloud.ply");
  EXPECT_EQ(Run(workspace() / "missing").code(), StatusCode::kBadInput);
}

TEST(BootstrapOptionsTest, DefaultsAreWithinTheirRanges) {
  BootstrapStageOptions options;
  pipeline::OptionTable table;
  RegisterBootstrapOptions(options, table);
  EXPECT_TRUE(table.Check().ok()) << table.Check().message();
  EXPECT_TRUE(MakeBootstrappingOptions(options).ok());
}

TEST(BootstrapOptionsTest, OnlyTheMethodAsPublishedRefinesMasks) {
  BootstrapStageOptions options;
  for (const char* const mode : {"lift", "geometry", "paper"}) {
    options.mode = mode;
    EXPECT_EQ(MakeBootstrappingOptions(options)->instances.refine,
              options.mode == "paper");
  }
}

}  // namespace
}  // namespace freegs::stages
