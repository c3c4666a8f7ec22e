// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/export_stage.h"

#include <functional>
#include <map>
#include <numeric>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "splat/scene/splat_format.h"
#include "splat/scene/spz_format.h"
#include "stages/evaluation/ground_truth.h"
#include "stages/export/report_page.h"
#include "stages/scene/exposure_file.h"
#include "stages/scene/scene_instances.h"
#include "stages/viewer/web_bundle.h"
#include "tests/stages/renamed_photo.h"
#include "tests/stages/synthetic_workspace.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class ExportStageTest : public testing::Test {
 protected:
  Status Run(const ExportStageOptions& options = {}) {
    return Run(options, pool_);
  }

  Status Run(const ExportStageOptions& options, ThreadPool& pool) {
    pipeline::StageContext context;
    context.workspace = workspace_.path();
    context.output = workspace_ / "export";
    context.pool = &pool;
    context.cancellation = &cancellation_;
    context.progress = [this](const Progress& progress) {
      if (on_progress_) on_progress_(progress);
    };
    context.log = [this](pipeline::LogLevel, const std::string& line) {
      log_ += line + "\n";
    };
    fs::create_directories(context.output);
    const Status status = MakeExportStage(options)->Run(context);
    summary_ = context.summary;
    return status;
  }

  fs::path Out(const std::string& name) const {
    return workspace_ / "export" / name;
  }

  // The content of all files that the stage wrote, by their paths.
  std::map<std::string, std::string> Files() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(Out(""))) {
      if (!entry.is_regular_file()) continue;
      files[fs::relative(entry.path(), Out("")).generic_string()] =
          ReadText(entry.path());
    }
    return files;
  }

  // The mean of all numbers of a picture of the report.
  double MeanOf(const std::string& name) const {
    const auto picture = ReadRgb(Out("report/views/" + name));
    EXPECT_TRUE(picture.ok()) << picture.status().message();
    if (!picture.ok()) return 0;
    const uint8_t* const data = picture->data();
    return std::accumulate(data, data + picture->size(), 0.0) /
           static_cast<double>(picture->size());
  }

  // The values of all attributes src and href of the page.
  std::set<std::string> Links() const {
    const std::string page = ReadText(Out("report/index.html"));
    std::set<std::string> links;
    for (const std::string attribute : {"src=\"", "href=\""}) {
      size_t at = 0;
      while ((at = page.find(attribute, at)) != std::string::npos) {
        at += attribute.size();
        links.insert(page.substr(at, page.find('"', at) - at));
      }
    }
    return links;
  }

  SyntheticWorkspace workspace_;
  ThreadPool pool_{2};
  CancellationToken cancellation_;
  std::function<void(const Progress&)> on_progress_;
  std::string log_;
  nlohmann::json summary_;
};

TEST_F(ExportStageTest, WritesSceneInstancesMasksAndBoxes) {
  workspace_.AddInstances();
  ExportStageOptions options;
  options.mask_views = 2;
  const Status status = Run(options);
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(ReadText(Out("scene.ply")), splat::SerializePly(workspace_.model));
  EXPECT_EQ(ReadText(Out("scene.spz")),
            splat::SerializeSpz(workspace_.model).value());
  EXPECT_EQ(ReadText(Out("scene.splat")),
            splat::SerializeSplat(workspace_.model));
  EXPECT_EQ(ReadText(Out("instances.ply")),
            splat::SerializePly(
                ColorByInstance(workspace_.model, workspace_.labels)));

  // Boxes have the form of a truth file.
  const auto objects = ReadTrueObjects(Out("boxes.json"));
  ASSERT_TRUE(objects.ok()) << objects.status().message();
  ASSERT_EQ(objects->size(), 3u);
  const auto boxes = nlohmann::json::parse(ReadText(Out("boxes.json")));
  for (size_t i = 0; i < 3; ++i) {
    const semantics::Instance& instance = workspace_.instances[i];
    EXPECT_EQ((*objects)[i].id, instance.id);
    EXPECT_TRUE((*objects)[i].aabb->min.isApprox(instance.aabb.min));
    EXPECT_NEAR(boxes.at("objects").at(i).at("obb").at("rotation").at(0).at(1),
                instance.obb.rotation(0, 1),
                1e-9);
  }
  EXPECT_THAT(ReadText(Out("boxes.ply")), HasSubstr("element vertex 288\n"));

  // Two holdout and two training photos, masks of the photos' size.
  int folders = 0;
  for (const auto& entry : fs::directory_iterator(Out("masks"))) {
    EXPECT_TRUE(entry.is_directory());
    ++folders;
  }
  EXPECT_EQ(folders, 4);
  EXPECT_EQ(summary_["mask_views"], 4);
  const View& view = workspace_.views[3];
  const Image<int32_t> map = splat::RenderLabels(workspace_.model,
                                                 view.camera,
                                                 view.cam_from_world,
                                                 splat::RenderOptions(),
                                                 pool_,
                                                 workspace_.labels);
  for (int label = 0; label < 3; ++label) {
    const auto mask =
        ReadLabels(Out("masks/photo3/" + std::to_string(label + 1) + ".png"));
    ASSERT_TRUE(mask.ok()) << mask.status().message();
    ASSERT_EQ(mask->size(), map.size());
    for (size_t k = 0; k < map.size(); ++k) {
      ASSERT_EQ(mask->data()[k], map.data()[k] == label ? 255 : 0);
    }
  }
}

TEST_F(ExportStageTest, MasksHaveTheNameOfTheirPhotoAmongAllPhotos) {
  // photo3.png is held out, and photo3.jpg gets no masks.
  RenamePhoto(workspace_.path(), "photo4.png", "photo3.jpg");
  workspace_.AddInstances();
  ExportStageOptions options;
  options.mask_views = 0;
  const Status status = Run(options);
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(summary_["mask_views"], 2);
  EXPECT_TRUE(fs::is_directory(Out("masks/photo3.png")));
  EXPECT_FALSE(fs::exists(Out("masks/photo3")));
}

TEST_F(ExportStageTest, ReportLinksOnlyToFilesThatAreThere) {
  workspace_.AddInstances();
  WriteText(workspace_ / "reconstruct" / "progress.csv",
            "iteration,seconds,loss,num_gaussians,holdout_psnr\n"
            "50,1,0.2,100,\n100,2,0.1,120,21.5\n150,3,0.08,120,22.5\n");
  WriteText(workspace_ / "reconstruct" / "metrics.json",
            R"({"holdout_psnr": 26.125, "holdout_ssim": 0.8712,
                "num_gaussians": 48211, "iterations": 7000, "holdout_views":
                [{"name": "photo3.png", "psnr": 27.77, "ssim": 0.9}]})");
  WriteText(workspace_ / "sfm" / "health.json",
            R"({"verdict": "degraded", "reason": "few <photos>",
                "advice": "take more", "images": 8, "registered": 6,
                "mean_reprojection_error_px": 0.513})");
  ASSERT_TRUE(Run().ok());
  const std::string page = ReadText(Out("report/index.html"));
  const std::set<std::string> links = Links();
  EXPECT_GE(links.size(), 2u * 5 + 5);
  for (const std::string& link : links) {
    EXPECT_TRUE(fs::is_regular_file(Out("report") / link)) << link;
  }
  for (const char* text : {"26.12 dB",
                           "SSIM 0.871",
                           "48,211",
                           "6 of 8",
                           "0.51 px",
                           "27.77 dB",
                           "1 min 15 s",
                           "degraded. few &lt;photos&gt;; take more"}) {
    EXPECT_THAT(page, HasSubstr(text));
  }
  // The awkward file name appears escaped only, and nothing is loaded from
  // elsewhere.
  EXPECT_THAT(page, HasSubstr("a &lt;b&gt;&amp;&#39;c#d.png"));
  EXPECT_THAT(page, Not(HasSubstr("a <b>")));
  EXPECT_THAT(page, Not(HasSubstr("http")));
  const bool has_viewer = FindWebBundle().ok();
  EXPECT_EQ(links.contains("viewer.js"), has_viewer);
  EXPECT_EQ(fs::exists(Out("report/scene.js")), has_viewer);
  EXPECT_EQ(page.find("id=\"scene3d\"") != std::string::npos, has_viewer);
  EXPECT_EQ(page.find("id=\"curves\"") != std::string::npos, has_viewer);
  EXPECT_EQ(page.find("no 3D view here") == std::string::npos, has_viewer);
}

TEST_F(ExportStageTest, AScenePutInByHandHasNoFiguresOfTheOneBefore) {
  const fs::path folder = workspace_ / "reconstruct";
  WriteText(folder / "metrics.json",
            R"({"holdout_psnr": 26.125, "num_gaussians": 48211,
                "iterations": 7000, "holdout_views":
                [{"name": "photo3.png", "psnr": 27.77, "ssim": 0.9}]})");
  pipeline::StageRecord record = pipeline::ReadStageRecord(folder).value();
  record.outputs = pipeline::ListOutputFiles(folder, {"point_cloud.ply"});
  ASSERT_TRUE(pipeline::WriteStageRecord(folder, record).ok());
  ASSERT_TRUE(Run().ok());
  const std::string before = ReadText(Out("report/index.html"));
  for (const char* text : {"26.12 dB", "48,211", "27.77 dB"}) {
    EXPECT_THAT(before, HasSubstr(text));
  }
  EXPECT_THAT(log_, Not(HasSubstr("point_cloud.ply")));

  ASSERT_TRUE(splat::WritePly(folder / "point_cloud.ply",
                              splat::RandomSceneModel(77, 1, 6))
                  .ok());
  ASSERT_TRUE(Run().ok());
  const std::string after = ReadText(Out("report/index.html"));
  for (const char* text : {"26.12 dB", "48,211", "27.77 dB", "7,000"}) {
    EXPECT_THAT(after, Not(HasSubstr(text)));
  }
  EXPECT_THAT(after, HasSubstr("<dd class=\"value\">77</dd>"));
  EXPECT_THAT(after, HasSubstr("not measured for a scene put in by hand"));
  EXPECT_THAT(log_, HasSubstr("point_cloud.ply is not as stage reconstruct"));
}

TEST_F(ExportStageTest, ReportCountsPhotosThatAreNotUsed) {
  const fs::path file = workspace_ / "ingest" / "images.json";
  photos::PhotoList list = photos::ReadPhotoList(file).value();
  photos::Photo& photo = list.photos.emplace_back();
  photo.file = "photo9.png";
  photo.split = photos::PhotoSplit::kRejected;
  photo.reason = "blurrier than its neighbours";
  ASSERT_TRUE(photos::WritePhotoList(file, list).ok());
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(ReadText(Out("report/index.html")), HasSubstr(", 1 not used"));
}

TEST_F(ExportStageTest, ReportSaysWhenWordsAreWithheld) {
  workspace_.AddInstances();
  ASSERT_TRUE(Run().ok());
  EXPECT_THAT(ReadText(Out("report/index.html")),
              Not(HasSubstr("freegs_pipeline model")));
  WriteText(workspace_ / "bootstrap" / "metrics.json",
            R"({"num_words_withheld": 2})");
  ASSERT_TRUE(Run().ok());
  const std::string page = ReadText(Out("report/index.html"));
  EXPECT_THAT(page, HasSubstr("2 instances have no words"));
  EXPECT_THAT(page, HasSubstr("freegs_pipeline model"));
}

TEST_F(ExportStageTest, LeavesOutASpzThatCannotSayTheSizes) {
  for (float& scale : workspace_.model.log_scales) scale -= 9;
  ASSERT_TRUE(splat::WritePly(workspace_ / "reconstruct" / "point_cloud.ply",
                              workspace_.model)
                  .ok());
  ASSERT_TRUE(Run().ok());
  EXPECT_FALSE(fs::exists(Out("scene.spz")));
  EXPECT_TRUE(fs::exists(Out("scene.ply")));
  EXPECT_THAT(log_, HasSubstr("no scene.spz: "));
  EXPECT_THAT(log_, Not(HasSubstr(Out("scene.spz").string())));
}

TEST_F(ExportStageTest, WithoutInstancesTheRestIsThere) {
  const Status status = Run();
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_TRUE(fs::exists(Out("scene.ply")));
  EXPECT_FALSE(fs::exists(Out("masks")));
  EXPECT_FALSE(fs::exists(Out("boxes.json")));
  EXPECT_THAT(log_, HasSubstr("no instances"));
  EXPECT_THAT(ReadText(Out("report/index.html")),
              HasSubstr("Instances are not there"));
}

TEST_F(ExportStageTest, ReportOfABareWorkspaceSaysWhatIsMissing) {
  fs::remove_all(workspace_ / "ingest");
  fs::remove(workspace_ / "reconstruct" / "stage.json");
  fs::remove_all(workspace_ / "undistort" / "images");
  WriteText(workspace_ / "sfm" / "health.json", "[1, 2");
  ASSERT_TRUE(Run().ok());
  const std::string page = ReadText(Out("report/index.html"));
  EXPECT_THAT(page, HasSubstr("not there"));
  EXPECT_THAT(page,
              HasSubstr("Photographs that took part in training, because no "
                        "other one has a pose."));
}

TEST_F(ExportStageTest, DeeplyNestedHealthCountsAsMissing) {
  const std::string lists(1'000'000, '[');
  for (const std::string& text : {lists, lists + std::string(1'000'000, ']')}) {
    const auto registered = [&](const std::string& health) {
      WriteText(workspace_ / "sfm" / "health.json", health);
      fs::remove_all(Out(""));
      EXPECT_TRUE(Run().ok());
      const std::string page = ReadText(Out("report/index.html"));
      const size_t at = page.find("<dt>Registered</dt>");
      EXPECT_NE(at, std::string::npos);
      return page.substr(at, page.find("</div>", at) - at);
    };
    EXPECT_THAT(registered(R"({"images": 8, "registered": 6})"),
                HasSubstr("6 of 8"));
    EXPECT_THAT(registered(text), HasSubstr("not there"));
  }
}

TEST_F(ExportStageTest, PicturesHaveTheExposureInWhichPhotosAreMeasured) {
  ExportStageOptions options;
  options.report_views = 2;
  ASSERT_TRUE(Run(options).ok());
  const double bright[] = {MeanOf("1_render.jpg"), MeanOf("2_render.jpg")};
  // The photos show the scene at half of its brightness.
  for (const size_t i : {0, 1}) {
    const std::string render = std::to_string(i + 1) + "_render.jpg";
    ImageU8 photo = ReadRgb(Out("report/views/" + render)).value();
    for (size_t k = 0; k < photo.size(); ++k) photo.data()[k] /= 2;
    const std::string& name = workspace_.views[3 * i].name;
    ASSERT_TRUE(
        WriteImage(workspace_ / "undistort" / "images" / name, photo).ok());
  }
  ASSERT_TRUE(Run(options).ok());
  const double far[] = {MeanOf("1_difference.jpg"), MeanOf("2_difference.jpg")};
  const splat::AffineColor half{{0.5f, 0, 0, 0, 0, 0.5f, 0, 0, 0, 0, 0.5f, 0}};
  std::vector<splat::PhotoExposure> exposures;
  for (const size_t k : {1, 2, 4, 5}) {
    exposures.push_back({workspace_.views[k].name, half});
  }
  ASSERT_TRUE(
      WriteExposures(workspace_ / "reconstruct" / "exposure.json", exposures)
          .ok());
  ASSERT_TRUE(Run(options).ok());
  EXPECT_NEAR(MeanOf("1_render.jpg"), bright[0] / 2, 1);
  EXPECT_NEAR(MeanOf("2_render.jpg"), bright[1] / 2, 1);
  EXPECT_LT(MeanOf("1_difference.jpg"), far[0] / 4);
  EXPECT_LT(MeanOf("2_difference.jpg"), far[1] / 4);
}

TEST_F(ExportStageTest, ExposuresAreAnInput) {
  EXPECT_THAT(MakeExportStage({})->Inputs({}),
              testing::Contains(fs::path("reconstruct/exposure.json")));
}

TEST_F(ExportStageTest, BoxSizesAreShownToThreeDigits) {
  ReportData data;
  data.has_instances = true;
  data.instances.resize(2);
  data.instances[0].box_size = {0.0012, 0.00345, 0.0005};
  data.instances[1].box_size = {1.25, 0.5, 0.125};
  const std::string page = RenderReportPage(data);
  EXPECT_THAT(page, HasSubstr("0.00120 \u00d7 0.00345 \u00d7 0.00050<"));
  EXPECT_THAT(page, HasSubstr("1.25 \u00d7 0.50 \u00d7 0.12<"));
}

TEST_F(ExportStageTest, SameBytesForAnyNumberOfThreads) {
  workspace_.AddInstances();
  workspace_.AddHierarchy();
  ASSERT_TRUE(Run().ok());
  const std::map<std::string, std::string> files = Files();
  const nlohmann::json summary = summary_;
  for (const char* name : {"scene.ply", "boxes.ply", "report/index.html"}) {
    EXPECT_TRUE(files.contains(name)) << name;
  }
  fs::remove_all(Out(""));
  ThreadPool single(1);
  ASSERT_TRUE(Run({}, single).ok());
  const std::map<std::string, std::string> again = Files();
  EXPECT_EQ(again.size(), files.size());
  for (const auto& [name, bytes] : files) {
    ASSERT_TRUE(again.contains(name)) << name;
    EXPECT_TRUE(again.at(name) == bytes) << name;
  }
  EXPECT_EQ(summary_, summary);
}

TEST_F(ExportStageTest, InstancesOfAnotherModelAreRefused) {
  workspace_.AddInstances();
  ASSERT_TRUE(splat::WritePly(workspace_ / "reconstruct" / "point_cloud.ply",
                              splat::RandomSceneModel(7, 0, 1))
                  .ok());
  EXPECT_EQ(Run().code(), StatusCode::kBadInput);
}

TEST_F(ExportStageTest, StopsWhenAsked) {
  // At the last picture of the report, before its page.
  on_progress_ = [this](const Progress& progress) {
    if (progress.done == progress.total - 1) cancellation_.Cancel();
  };
  EXPECT_EQ(Run().code(), StatusCode::kInterrupted);
  EXPECT_TRUE(fs::exists(Out("report/views")));
  EXPECT_FALSE(fs::exists(Out("report/viewer.js")));
  EXPECT_FALSE(fs::exists(Out("report/index.html")));
  // At once, before the first file.
  fs::remove_all(Out(""));
  EXPECT_EQ(Run().code(), StatusCode::kInterrupted);
  EXPECT_FALSE(fs::exists(Out("scene.ply")));
}

TEST_F(ExportStageTest, OptionsAreInTheTable) {
  ExportStageOptions options;
  pipeline::OptionTable table;
  RegisterExportOptions(options, table);
  ASSERT_TRUE(table.Check().ok());
  const auto line = table.ParseCommandLine({"--export.mask_views", "3"});
  ASSERT_TRUE(line.ok());
  ASSERT_TRUE(table.Apply(line->settings).ok());
  EXPECT_EQ(options.mask_views, 3);
}

}  // namespace
}  // namespace freegs::stages
