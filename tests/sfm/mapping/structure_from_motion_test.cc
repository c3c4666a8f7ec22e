// SPDX-License-Identifier: BSD-3-Clause
// The steps of structure from motion, on a fake COLMAP.

#include "sfm/mapping/structure_from_motion.h"

#include <algorithm>
#include <csignal>
#include <set>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sfm/mapping/step_record.h"
#include "sfm/matching/match_database.h"
#include "sfm/scene/model_io.h"
#include "sfm/scene/model_io_binary.h"
#include "tests/sfm/mapping/structure_from_motion_fixture.h"
#include "tests/sfm/synthetic_model.h"
#include "tests/sfm/textured_photo.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST_F(StructureFromMotionTest, BothDialects) {
  for (const char* dialect : {"3", "4"}) {
    fs::remove_all(input_.work_folder);
    std::map<std::string, double> last;
    input_.progress = [&](const Progress& progress) {
      EXPECT_LE(progress.done, progress.total);
      last[progress.step] = progress.done;
    };
    const auto result = Run({{"FAKE_COLMAP_DIALECT", dialect}});
    ASSERT_TRUE(result.ok()) << result.status().message();
    ASSERT_EQ(result->models.size(), 1u);
    EXPECT_EQ(result->models[0].images.size(), 10u);
    EXPECT_TRUE(result->warnings.empty());
    EXPECT_TRUE(result->unregistered.empty());
    EXPECT_EQ(last["features"], 10);
    EXPECT_EQ(last["matching"], 45);
    EXPECT_EQ(last["mapping"], 10);
    EXPECT_EQ(result->colmap_version[0], dialect[0]);
    EXPECT_EQ(result->pairs.strategy, "exhaustive");
    EXPECT_EQ(result->pairs.pairs, 45u);
    EXPECT_EQ(result->pairs.all_pairs, 45u);
    EXPECT_THAT(ReadText(input_.work_folder / "pairs.txt"),
                testing::StartsWith(PhotoName(0) + " " + PhotoName(1) + "\n"));
    EXPECT_TRUE(fs::exists(input_.work_folder / "database.db"));
  }
}

TEST_F(StructureFromMotionTest, ChoosesCameras) {
  // The fake's tracks are exact, of a lens with two radial terms.
  auto result = Run();
  ASSERT_TRUE(result.ok()) << result.status().message();
  const auto chosen = std::find_if(result->camera_models.begin(),
                                   result->camera_models.end(),
                                   [](const auto& row) { return row.chosen; });
  ASSERT_NE(chosen, result->camera_models.end());
  ASSERT_EQ(result->models[0].cameras.size(), 1u);
  EXPECT_EQ(result->models[0].cameras[0].model, chosen->model);
  EXPECT_LT(chosen->held_out_error_px, 0.02);
  EXPECT_NEAR(result->models[0].cameras[0].FocalX(), 600, 1);

  // A fixed model is left to COLMAP.
  fs::remove_all(input_.work_folder);
  options_.camera_model = "RADIAL";
  result = Run();
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_TRUE(result->camera_models.empty());
  EXPECT_EQ(result->models[0].cameras[0].params,
            SyntheticModel(1, 0).cameras[0].params);

  fs::remove_all(input_.work_folder);
  options_.camera_model = "auto";
  options_.camera = "per_image";
  result = Run();
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_EQ(result->models[0].cameras.size(), 10u);
}

TEST_F(StructureFromMotionTest, BestModelFirstAndReasons) {
  const auto result =
      Run({{"FAKE_COLMAP_MODELS", "1,2,7"}, {"FAKE_COLMAP_RELAXED", "5"}});
  ASSERT_TRUE(result.ok()) << result.status().message();
  ASSERT_EQ(result->models.size(), 3u);
  EXPECT_EQ(result->models[0].images.size(), 7u);
  EXPECT_EQ(result->models[1].images.size(), 2u);
  EXPECT_EQ(result->models[2].images.size(), 1u);
  ASSERT_EQ(result->unregistered.size(), 3u);
  EXPECT_THAT(result->unregistered.begin()->second, HasSubstr("sparse/2"));
}

TEST_F(StructureFromMotionTest, LowerThresholdsWhenFewRegister) {
  const auto result =
      Run({{"FAKE_COLMAP_MODELS", "4"}, {"FAKE_COLMAP_RELAXED", "8"}});
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->models[0].images.size(), 8u);
  ASSERT_EQ(result->warnings.size(), 1u);
  EXPECT_THAT(result->warnings[0], HasSubstr("4 of 10"));
}

TEST_F(StructureFromMotionTest, CamerasThatNoPhotoHasAreNoModel) {
  const auto result = Run({{"FAKE_COLMAP_SENSELESS", "1"}});
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_EQ(result->models[0].images.size(), 10u);
  EXPECT_GT(result->models[0].cameras.begin()->FocalX(), 100);
  ASSERT_GE(result->attempts.size(), 2u);
  EXPECT_EQ(result->attempts[0].registered, 0);
  EXPECT_TRUE(result->attempts[1].kept);
}

TEST_F(StructureFromMotionTest, GoodResultsNeedNoOtherAttempt) {
  const auto result = Run();
  ASSERT_TRUE(result.ok());
  EXPECT_THAT(AttemptNames(result->attempts), testing::ElementsAre("mapping"));
  EXPECT_TRUE(result->attempts[0].kept);
  EXPECT_EQ(result->attempts[0].registered, 10);
}

TEST_F(StructureFromMotionTest, AttemptsAreNotRepeated) {
  const Settings settings = {{"FAKE_COLMAP_MODELS", "4"},
                             {"FAKE_COLMAP_RELAXED", "6"}};
  const auto result = Run(settings);
  ASSERT_TRUE(result.ok()) << result.status().message();
  const std::vector<Attempt>& attempts = result->attempts;
  EXPECT_THAT(
      AttemptNames(attempts),
      testing::ElementsAre("mapping", "lower thresholds", "small models"));
  EXPECT_FALSE(attempts[2].kept);
  EXPECT_THAT(attempts[1].why, HasSubstr("6 photos left out"));
  EXPECT_TRUE(attempts[1].kept);
  EXPECT_EQ(result->models[0].images.size(), 6u);
  EXPECT_EQ(result->unregistered.size(), 4u);
  EXPECT_THAT(result->warnings.at(0), HasSubstr("lower thresholds"));

  // Nothing that is done is done again, and the result is the same.
  const std::string mapper = Log("mapper");
  const std::string extractor = Log("feature_extractor");
  const auto again = Run(settings);
  ASSERT_TRUE(again.ok()) << again.status().message();
  EXPECT_EQ(Log("mapper"), mapper);
  EXPECT_EQ(Log("feature_extractor"), extractor);
  EXPECT_EQ(AttemptNames(again->attempts), AttemptNames(attempts));
  EXPECT_EQ(PointsToBinary(again->models[0].points3d),
            PointsToBinary(result->models[0].points3d));

  TidyWorkFolder(input_.work_folder);
  EXPECT_TRUE(fs::exists(input_.work_folder / "database.db"));
  EXPECT_FALSE(fs::exists(input_.work_folder / "attempts"));
}

TEST_F(StructureFromMotionTest, WorseAttemptsAreNotKept) {
  const auto result =
      Run({{"FAKE_COLMAP_MODELS", "4"}, {"FAKE_COLMAP_RELAXED", "3"}});
  ASSERT_TRUE(result.ok()) << result.status().message();
  ASSERT_EQ(result->attempts.size(), 3u);
  EXPECT_FALSE(result->attempts[1].kept);
  EXPECT_FALSE(result->attempts[2].kept);
  EXPECT_EQ(result->attempts[1].registered, 3);
  EXPECT_EQ(result->models[0].images.size(), 4u);
}

// COLMAP gives up models of few photos, though nothing else may come.
TEST_F(StructureFromMotionTest, SmallModelsAreTheLastResort) {
  const auto result = Run({{"FAKE_COLMAP_MODELS", ""},
                           {"FAKE_COLMAP_RELAXED", ""},
                           {"FAKE_COLMAP_SMALL", "7"}});
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_THAT(
      AttemptNames(result->attempts),
      testing::ElementsAre("mapping", "lower thresholds", "small models"));
  EXPECT_FALSE(result->attempts[1].kept);
  EXPECT_TRUE(result->attempts[2].kept);
  EXPECT_EQ(result->models[0].images.size(), 7u);
  EXPECT_EQ(result->unregistered.size(), 3u);
  EXPECT_THAT(result->warnings.at(0), HasSubstr("small models"));
}

TEST_F(StructureFromMotionTest, TooFewPhotosAreNotTriedAgain) {
  input_.photos.resize(2);
  const auto result = Run({{"FAKE_COLMAP_MODELS", ""}});
  ASSERT_TRUE(result.ok());
  EXPECT_THAT(AttemptNames(result->attempts), testing::ElementsAre("mapping"));
  ASSERT_FALSE(result->findings.empty());
  EXPECT_EQ(result->findings[0].kind, FindingKind::kTooFewPhotos);
}

TEST_F(StructureFromMotionTest, NoModelIsAResult) {
  const auto result = Run({{"FAKE_COLMAP_MODELS", ""}});
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_TRUE(result->models.empty());
  EXPECT_EQ(result->unregistered.size(), 10u);
  EXPECT_THAT(result->unregistered.begin()->second, HasSubstr("matches 9"));
}

TEST_F(StructureFromMotionTest, FailingCommandsNameTheLog) {
  for (const char* command :
       {"feature_extractor", "matches_importer", "mapper"}) {
    fs::remove_all(input_.work_folder);
    const auto result =
        Run({{"FAKE_COLMAP_FAIL", command}, {"FAKE_COLMAP_MODELS", "10"}});
    if (std::string(command) == "mapper") {
      // Indistinguishable from finding no model.
      ASSERT_TRUE(result.ok());
      EXPECT_TRUE(result->models.empty());
      continue;
    }
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.status().code(), StatusCode::kUnusableResult);
    EXPECT_THAT(result.status().message(), HasSubstr("something went wrong"));
    EXPECT_THAT(result.status().message(),
                HasSubstr(std::string(command) + ".log"));
    EXPECT_THAT(Log(command), HasSubstr("something went wrong"));
  }
}

// The machine killed it, or it crashed: the photos may still do.
TEST_F(StructureFromMotionTest, ASignalIsNoVerdict) {
  for (const int signal : {SIGKILL, SIGSEGV}) {
    for (const char* command :
         {"feature_extractor", "matches_importer", "mapper"}) {
      if (signal != SIGKILL && command != std::string("mapper")) continue;
      fs::remove_all(input_.work_folder);
      const auto result = Run({{"FAKE_COLMAP_FAIL", command},
                               {"FAKE_COLMAP_SIGNAL", std::to_string(signal)}});
      EXPECT_EQ(result.status().code(), StatusCode::kInternal);
      EXPECT_THAT(result.status().message(),
                  HasSubstr("signal " + std::to_string(signal)));
      EXPECT_EQ(result.status().message().find("memory") != std::string::npos,
                signal == SIGKILL);
    }
    const std::string features = Log("feature_extractor");
    EXPECT_TRUE(Run().ok());
    EXPECT_EQ(Log("feature_extractor"), features);
  }
}

TEST_F(StructureFromMotionTest, ACrashOfAFurtherAttemptKeepsTheFirst) {
  const fs::path once = folder_ / "once";
  input_.progress = [&](const Progress& progress) {
    if (progress.step == "mapping, lower thresholds") WriteText(once, "");
  };
  const auto result = Run({{"FAKE_COLMAP_MODELS", "4"},
                           {"FAKE_COLMAP_FAIL", "mapper"},
                           {"FAKE_COLMAP_SIGNAL", std::to_string(SIGABRT)},
                           {"FAKE_COLMAP_ONCE", once.string()}});
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_EQ(result->models[0].images.size(), 4u);
  ASSERT_EQ(result->attempts.size(), 3u);
  EXPECT_THAT(result->attempts[1].problem, HasSubstr("signal 6"));
}

TEST_F(StructureFromMotionTest, CancellationWhileAProgramHangs) {
  CancellationToken token;
  input_.cancellation = &token;
  std::thread canceller;
  input_.progress = [&](const Progress& progress) {
    // Matching was announced: its program is about to hang.
    if (progress.step == "matching" && !canceller.joinable()) {
      canceller = std::thread([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
        token.Cancel();
      });
    }
  };
  const auto result = Run({{"FAKE_COLMAP_HANG", "matches_importer"}});
  canceller.join();
  EXPECT_EQ(result.status().code(), StatusCode::kInterrupted);
}

// What is done is not done again.
TEST_F(StructureFromMotionTest, ContinuesAfterTheLastFinishedStep) {
  EXPECT_FALSE(Run({{"FAKE_COLMAP_FAIL", "matches_importer"}}).ok());
  const std::string features = Log("feature_extractor");
  EXPECT_FALSE(features.empty());
  const auto resumed = Run();
  ASSERT_TRUE(resumed.ok()) << resumed.status().message();
  EXPECT_EQ(Log("feature_extractor"), features);

  input_.work_folder = folder_ / "undisturbed";
  const auto straight = Run();
  ASSERT_TRUE(straight.ok());
  EXPECT_EQ(PointsToBinary(resumed->models[0].points3d),
            PointsToBinary(straight->models[0].points3d));
}

TEST_F(StructureFromMotionTest, MatchingContinuesAtItsPortion) {
  // 45 pairs are three portions; one fails once.
  options_.num_threads = 1;
  const fs::path once = folder_ / "once";
  const Settings settings = {{"FAKE_COLMAP_FAIL", "matches_importer"},
                             {"FAKE_COLMAP_ONCE", once.string()}};
  WriteText(once, "");
  EXPECT_FALSE(Run(settings).ok());
  const auto resumed = Run(settings);
  ASSERT_TRUE(resumed.ok()) << resumed.status().message();
  size_t runs = 0;
  const std::string log = Log("matches_importer");
  for (size_t at = 0; (at = log.find("Matching block", at)) != log.npos; ++at) {
    ++runs;
  }
  EXPECT_EQ(runs, 3u);
  for (const auto& entry : fs::directory_iterator(input_.work_folder)) {
    EXPECT_THAT(
        entry.path().filename().string(),
        testing::AnyOf(
            "database.db", "steps.json", "logs", "attempts", "pairs.txt"));
  }
  TidyWorkFolder(input_.work_folder);
  for (const auto& entry : fs::directory_iterator(input_.work_folder)) {
    EXPECT_THAT(entry.path().filename().string(),
                testing::AnyOf("database.db", "logs", "pairs.txt"));
  }
}

TEST_F(StructureFromMotionTest, ImageSizeIsChosen) {
  // Small photos: taken as they are.
  const auto small = Run();
  ASSERT_TRUE(small.ok());
  EXPECT_EQ(small->image_size, 1600);
  // Photos of 160 pixels have by far too few features.
  for (SfmPhoto& photo : input_.photos) photo.width = 4000;
  input_.work_folder = folder_ / "large";
  const auto large = Run();
  ASSERT_TRUE(large.ok()) << large.status().message();
  EXPECT_EQ(large->image_size, 1600);
  EXPECT_THAT(ReadText(input_.work_folder / "steps.json"),
              HasSubstr("\"image_size\": 1600"));
  options_.max_image_size = 900;
  input_.work_folder = folder_ / "given";
  const auto given = Run();
  ASSERT_TRUE(given.ok());
  EXPECT_EQ(given->image_size, 900);
  options_.max_image_size = 63;
  EXPECT_EQ(Run().status().code(), StatusCode::kInvalidArgument);
}

// The fake's photos all look the same, so each is first matched with the
// first ones only, and then, having too few partners, with more.
TEST_F(StructureFromMotionTest, ChosenPairsContinueAtTheirPortion) {
  options_.num_threads = 1;
  options_.pairs.matcher = "retrieval";
  options_.pairs.num_neighbours = 2;
  const auto straight = Run();
  ASSERT_TRUE(straight.ok()) << straight.status().message();
  EXPECT_EQ(straight->pairs.strategy, "retrieval");
  EXPECT_GE(straight->pairs.pairs, 20u);
  EXPECT_LT(straight->pairs.pairs, 45u);
  EXPECT_EQ(straight->pairs.all_pairs, 45u);
  const std::string log = Log("matches_importer");
  const std::string list = ReadText(input_.work_folder / "pairs.txt");

  // Fails at its second and its third portion.
  input_.work_folder = folder_ / "disturbed";
  const fs::path once = folder_ / "once";
  const Settings fail = {{"FAKE_COLMAP_FAIL", "matches_importer"},
                         {"FAKE_COLMAP_ONCE", once.string()}};
  bool matched = false;
  for (int failures = 0; failures < 2; ++failures) {
    input_.progress = [&](const Progress& progress) {
      if (progress.step != "matching" || progress.done == 0) return;
      if (matched) return;
      matched = true;
      WriteText(once, "");
    };
    matched = false;
    EXPECT_FALSE(Run(fail).ok());
  }
  input_.progress = nullptr;
  const auto resumed = Run();
  ASSERT_TRUE(resumed.ok()) << resumed.status().message();
  EXPECT_EQ(resumed->pairs.strategy, straight->pairs.strategy);
  EXPECT_EQ(resumed->pairs.pairs, straight->pairs.pairs);
  EXPECT_EQ(ReadText(input_.work_folder / "pairs.txt"), list);
  const auto count = [](const std::string& text) {
    size_t runs = 0;
    for (size_t at = 0; (at = text.find("Matching block", at)) != text.npos;
         ++at) {
      ++runs;
    }
    return runs;
  };
  EXPECT_EQ(count(Log("matches_importer")), count(log));
  // Asked again after matching is done.
  const auto again = Run();
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again->pairs.pairs, straight->pairs.pairs);
}

TEST_F(StructureFromMotionTest, BrokenStepRecordStartsAgain) {
  ASSERT_TRUE(Run().ok());
  for (const char* text : {"", "[", "[]", "{\"done\": 3}", "{\"done\":[7]}"}) {
    WriteText(input_.work_folder / "steps.json", text);
    EXPECT_TRUE(Run().ok()) << text;
  }
}

TEST_F(StructureFromMotionTest, StepsOfAnotherColmapAreDoneAgain) {
  ASSERT_TRUE(Run().ok());
  const fs::path& folder = input_.work_folder;
  WriteText(folder / "steps.json",
            R"({"colmap": "3.8", "done": ["features"]})");
  EXPECT_TRUE(StepRecord(folder, "3.8").Has("features"));
  EXPECT_FALSE(StepRecord(folder, "4.1").Has("features"));
  EXPECT_TRUE(Run().ok());
}

TEST_F(StructureFromMotionTest, MissingProgramAndWrongOptions) {
  options_.colmap = "/nonexistent/colmap";
  EXPECT_EQ(RunStructureFromMotion(input_, options_).status().code(),
            StatusCode::kMissingDependency);
  options_.camera_model = "PANORAMA";
  EXPECT_EQ(RunStructureFromMotion(input_, options_).status().code(),
            StatusCode::kInvalidArgument);
  options_ = SfmOptions();
  input_.photos[0].name = " leading space.jpg";
  EXPECT_EQ(RunStructureFromMotion(input_, options_).status().code(),
            StatusCode::kBadInput);
}

}  // namespace
}  // namespace freegs::sfm
