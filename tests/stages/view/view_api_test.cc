// SPDX-License-Identifier: BSD-3-Clause
// What the server answers, through the client of the library.

#include "stages/view/view_api.h"

#include <atomic>
#include <future>
#include <httplib.h>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base64.h"
#include "pipeline/progress_file.h"
#include "pipeline/workspace.h"
#include "splat/scene/ply_io.h"
#include "stages/query/file_stamp.h"
#include "tests/stages/view/view_fixture.h"

namespace freegs::stages {
namespace {

using nlohmann::json;
using testing::HasSubstr;
namespace fs = std::filesystem;

class ViewApiTest : public ViewTest {
 protected:
  httplib::Result Get(const std::string& path) const {
    return httplib::Client("127.0.0.1", port()).Get(path);
  }
  json GetJson(const std::string& path) const {
    const auto answer = Get(path);
    EXPECT_TRUE(answer && answer->status == 200) << path;
    return answer ? json::parse(answer->body) : json();
  }
  httplib::Result Post(const json& question) const {
    return httplib::Client("127.0.0.1", port())
        .Post("/api/query", question.dump(), "application/json");
  }
  json Ask(const json& question, int status = 200) const {
    const auto answer = Post(question);
    EXPECT_TRUE(answer && answer->status == status)
        << (answer ? answer->body : "no answer");
    return answer ? json::parse(answer->body) : json();
  }
};

TEST_F(ViewApiTest, TheFrontPageIsTheReportOrTheRun) {
  Start();
  const auto front = Get("/");
  ASSERT_TRUE(front);
  EXPECT_EQ(front->status, 302);
  EXPECT_EQ(front->get_header_value("Location"), "/report/");
  const auto report = Get("/report/");
  ASSERT_TRUE(report);
  EXPECT_EQ(report->body, "<p>The report</p>");
  EXPECT_EQ(report->get_header_value("Content-Type"),
            "text/html; charset=utf-8");

  fs::remove_all(workspace_ / "export");
  const auto live = Get("/");
  ASSERT_TRUE(live);
  EXPECT_EQ(live->status, 200);
  EXPECT_THAT(live->body, HasSubstr("3D viewer was not built"));
}

TEST_F(ViewApiTest, ServesTheBundleOfThePage) {
  const TemporaryFolder web;
  web.Write("live.html", "<p>Live</p>");
  web.Write("viewer.js", "let x;");
  options_.web = web.path();
  fs::remove_all(workspace_ / "export");
  Start();
  EXPECT_EQ(Get("/")->body, "<p>Live</p>");
  const auto script = Get("/web/viewer.js");
  ASSERT_TRUE(script);
  EXPECT_EQ(script->body, "let x;");
  EXPECT_EQ(script->get_header_value("Content-Type"),
            "text/javascript; charset=utf-8");
  EXPECT_EQ(Get("/web/")->status, 404);
}

TEST_F(ViewApiTest, PhotosAreThoseOfViews) {
  WriteText(workspace_ / "undistort/images/notes.txt", "no view");
  Start();
  const std::string& name = workspace_.views[0].name;  // "a <b>&'c#d.png"
  const auto photo = Get("/api/photos/a%20%3Cb%3E%26%27c%23d.png");
  ASSERT_TRUE(photo);
  EXPECT_EQ(photo->status, 200);
  EXPECT_EQ(photo->get_header_value("Content-Type"), "image/png");
  EXPECT_EQ(photo->body, ReadText(workspace_ / "undistort/images" / name));
  for (const char* target :
       {"notes.txt", "photo1", "PHOTO1.PNG", "photo99.png", ""}) {
    EXPECT_EQ(Get(std::string("/api/photos/") + target)->status, 404) << target;
  }
}

TEST_F(ViewApiTest, AnInstanceIsWhatExportWrites) {
  Start();
  const auto answer = Get("/api/instances/2.ply");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 200);
  auto world = splat::ReadPly(workspace_ / "reconstruct/point_cloud.ply");
  ASSERT_TRUE(world.ok());
  std::vector<uint32_t> gaussians;
  for (size_t i = 0; i < workspace_.labels.size(); ++i) {
    if (workspace_.labels[i] == 1) gaussians.push_back(i);
  }
  world->model.Select(gaussians);
  EXPECT_EQ(answer->body, splat::SerializePly(world->model, world->offset));
  // The page gives the file a name.
  EXPECT_EQ(answer->get_header_value("Content-Disposition"), "attachment");
  for (const char* name : {"99.ply", "0.ply"}) {
    EXPECT_THAT(Get(std::string("/api/instances/") + name)->body,
                HasSubstr("error"));
    EXPECT_EQ(Get(std::string("/api/instances/") + name)->status, 404) << name;
  }
  for (const char* name :
       {"-1.ply", "2", "2.splat", "2x.ply", "99999999999.ply", ".ply"}) {
    EXPECT_EQ(Get(std::string("/api/instances/") + name)->status, 404) << name;
  }
}

TEST_F(ViewApiTest, AnswersEachKindOfQuestion) {
  Start();
  const json text = Ask({{"text", "red apple"}});
  EXPECT_EQ(text["found"], true);
  EXPECT_EQ(text["hits"][0]["id"], 1);
  EXPECT_GT(text["timings"]["encode_ms"].get<double>(), 0);
  EXPECT_EQ(Ask({{"text", "wooden box"}})["hits"][0]["id"], 2);

  const json example =
      Ask({{"example",
            EncodeBase64(ReadText(workspace_ / "undistort/images/photo1.png"))},
           {"max_hits", 0}});
  EXPECT_EQ(example["query"]["kind"], "example");
  EXPECT_EQ(example["hits"].size(), 2u);

  // A pixel of several instances, of which none has half.
  const json click = {
      {"view", "photo1.png"}, {"x", 24}, {"y", 18}, {"level", 0}};
  const json clicked = Ask({{"click", click}});
  EXPECT_EQ(clicked["query"]["kind"], "click");
  ASSERT_FALSE(clicked["hits"].empty());
  json wide = click;
  wide["level"] = 1;
  const json wider = Ask({{"click", wide}});
  EXPECT_EQ(wider["query"]["level"], 1);
  EXPECT_GT(wider["hits"][0]["num_gaussians"].get<int>(),
            clicked["hits"][0]["num_gaussians"].get<int>());
  // A level is forgotten with its answer.
  json again = Ask({{"click", click}});
  again.erase("timings");
  json before = clicked;
  before.erase("timings");
  EXPECT_EQ(again, before);
}

TEST_F(ViewApiTest, WhatFindsNoPlaceIsRefusedAtOnce) {
  options_.max_at_once = 0;
  Start();
  // The picture, which ends after its first bytes, is not even read.
  for (const auto& answer : {Post({{"text", "red apple"}}),
                             Post({{"example", "iVBORw0KGgo="}}),
                             Get("/api/instances/2.ply")}) {
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->status, 429);
    EXPECT_EQ(answer->get_header_value("Retry-After"), "1");
    EXPECT_THAT(answer->body, HasSubstr("in a few seconds"));
  }
  // What is wrong is said all the same, and the rest is answered.
  EXPECT_THAT(Ask({{"text", 3}}, 400)["error"].get<std::string>(),
              HasSubstr("text"));
  EXPECT_EQ(GetJson("/api/status")["live"], true);
}

TEST_F(ViewApiTest, SaysWhatIsWrongWithAQuestion) {
  Start();
  json unknown = {{"click", {{"view", "nowhere"}, {"x", 1}, {"y", 1}}}};
  EXPECT_THAT(Ask(unknown, 404)["error"].get<std::string>(),
              HasSubstr("there is no such view"));
  json outside = {{"click", {{"view", "photo1"}, {"x", 9999}, {"y", 1}}}};
  EXPECT_THAT(Ask(outside, 400)["error"].get<std::string>(),
              HasSubstr("pixels"));
  EXPECT_THAT(Ask({{"text", 3}}, 400)["error"].get<std::string>(),
              HasSubstr("text"));
  fs::remove(workspace_ / "bootstrap/instance_features.json");
  EXPECT_THAT(Ask({{"text", "red apple"}}, 409)["error"].get<std::string>(),
              HasSubstr("run stage bootstrap"));
  const json queries = GetJson("/api/status")["queries"];
  EXPECT_EQ(queries["text"], false);
  EXPECT_EQ(queries["click"], true);
  EXPECT_THAT(queries["reason"].get<std::string>(), HasSubstr("semantics"));
}

TEST_F(ViewApiTest, NoticesANewScene) {
  Start();
  const std::string version = GetJson("/api/status")["scene_version"];
  EXPECT_EQ(Ask({{"text", "red apple"}})["hits"][0]["words"], json::array());
  workspace_.instances[0].words = {"apple"};
  ASSERT_TRUE(semantics::WriteInstances(workspace_ / "bootstrap/instances.json",
                                        workspace_.instances)
                  .ok());
  EXPECT_EQ(Ask({{"text", "red apple"}})["hits"][0]["words"],
            json::array({"apple"}));
  EXPECT_NE(GetJson("/api/status")["scene_version"], version);
  const std::string old_scene = "?scene=" + version;
  EXPECT_EQ(Get("/api/instances/2.ply" + old_scene)->status, 409);
  EXPECT_EQ(httplib::Client("127.0.0.1", port())
                .Post("/api/query" + old_scene,
                      R"({"text": "red apple"})",
                      "application/json")
                ->status,
            409);
}

TEST_F(ViewApiTest, NoticesANewSceneThatComesDuringTheAnswer) {
  const std::string stamp = QueryStamp(workspace_.path());
  RequestTarget target = {.path = "/api/query", .parameters = {}};
  int answered = 0;
  const auto ask = [&](const std::string& change) {
    return AnswerAboutScene(workspace_.path(), target, [&]() -> HttpResponse {
      ++answered;
      WriteText(workspace_ / "bootstrap/instances.json", change);
      return {};
    });
  };
  EXPECT_EQ(ask("another scene").status, 200);  // None was named.
  target.parameters["scene"] = stamp;
  EXPECT_EQ(ask("yet another").status, 409);  // It was gone before.
  EXPECT_EQ(answered, 1);
  target.parameters["scene"] = QueryStamp(workspace_.path());
  EXPECT_EQ(ask("replaced meanwhile").status, 409);
  EXPECT_EQ(answered, 2);
}

TEST_F(ViewApiTest, NoticesANewReport) {
  Start();
  const json before = GetJson("/api/status")["export_version"];
  EXPECT_NE(before, "");
  WriteText(workspace_ / "export/report/index.html", "<p>Another report</p>");
  EXPECT_NE(GetJson("/api/status")["export_version"], before);
  fs::remove_all(workspace_ / "export");
  EXPECT_EQ(GetJson("/api/status")["export_version"], "");
}

TEST_F(ViewApiTest, TellsOfARunUnderWay) {
  WriteText(workspace_ / "reconstruct.partial/progress.csv",
            "iteration,seconds,loss,num_gaussians,holdout_psnr\n"
            "50,1,0.5,100,\n100,2,0.25,200,20.5\n");
  WriteText(workspace_ / "preview.jpg", "a picture of the killed run");
  Start();
  // Without its lock this is what a killed run has left.
  json status = GetJson("/api/status");
  EXPECT_EQ(status["live"], true);
  EXPECT_EQ(status["running"], false);
  EXPECT_EQ(status["progress"], nullptr);
  EXPECT_EQ(status["preview"], nullptr);
  EXPECT_EQ(Get("/api/preview.jpg")->status, 404);
  EXPECT_EQ(status["stages"][3]["name"], "reconstruct");
  EXPECT_EQ(status["stages"][3]["state"], "interrupted");
  EXPECT_EQ(status["curve"]["iteration"], json::array());
  {
    const auto lock = pipeline::WorkspaceLock::Acquire(workspace_.path());
    ASSERT_TRUE(lock.ok());
    {
      // No stage but the training makes pictures.
      const pipeline::ProgressFile file(workspace_.path(), "sfm");
      status = GetJson("/api/status");
      EXPECT_EQ(status["progress"]["stage"], "sfm");
      EXPECT_EQ(status["preview"], nullptr);
    }
    const pipeline::ProgressFile file(workspace_.path(), "reconstruct");
    EXPECT_EQ(GetJson("/api/status")["preview"], nullptr);
    WriteText(workspace_ / "preview.jpg", "a picture");
    status = GetJson("/api/status");
    EXPECT_EQ(status["running"], true);
    EXPECT_EQ(status["stages"][3]["state"], "running");
    EXPECT_EQ(status["progress"]["stage"], "reconstruct");
    EXPECT_EQ(status["progress"]["seconds_left"], nullptr);
    EXPECT_EQ(status["curve"]["iteration"], json({50, 100}));
    EXPECT_EQ(status["curve"]["loss"], json({0.5, 0.25}));
    EXPECT_EQ(status["curve"]["num_gaussians"], json({100, 200}));
    EXPECT_EQ(status["curve"]["holdout_psnr"], json({nullptr, 20.5}));
    const std::string preview = status["preview"];
    EXPECT_THAT(preview, HasSubstr("/api/preview.jpg?v="));
    EXPECT_EQ(Get(preview)->body, "a picture");
  }
  EXPECT_EQ(GetJson("/api/status")["running"], false);
}

TEST_F(ViewApiTest, TheSceneComesInPartsAndIsMadeOnce) {
  int made = 0;
  options_.make_scene = [&made](const fs::path&) -> StatusOr<SceneParts> {
    ++made;
    SceneParts scene;
    scene.description = R"({"parts": 1})";
    scene.parts.push_back({std::make_shared<const std::string>("splats"),
                           std::make_shared<const std::string>("labels")});
    return scene;
  };
  Start();
  EXPECT_EQ(GetJson("/api/scene")["parts"], 1);
  EXPECT_EQ(Get("/api/parts/0/splats.spz")->body, "splats");
  EXPECT_EQ(Get("/api/parts/0/labels.bin")->body, "labels");
  const std::string stamp = Get("/api/scene")->get_header_value("Scene-Stamp");
  EXPECT_EQ(stamp, GetJson("/api/status")["scene_version"]);
  EXPECT_EQ(Get("/api/parts/0/labels.bin?scene=" + stamp)->body, "labels");
  EXPECT_EQ(Get("/api/parts/0/labels.bin?scene=other")->status, 409);
  for (const char* part :
       {"1/splats.spz", "-1/splats.spz", "x/labels.bin", "0/other.bin", "0"}) {
    EXPECT_EQ(Get(std::string("/api/parts/") + part)->status, 404) << part;
  }
  EXPECT_EQ(made, 1);
  // Among the photos, others may be held out now.
  for (const char* changed :
       {"bootstrap/hierarchy.json", "ingest/images.json"}) {
    WriteText(workspace_ / changed, "{}");
    EXPECT_EQ(Get("/api/scene")->status, 200);
  }
  EXPECT_EQ(made, 3);
}

TEST_F(ViewApiTest, NobodyWaitsWhileTheSceneIsMade) {
  std::promise<void> begun;
  std::promise<void> release;
  std::atomic<int> made = 0;
  options_.make_scene = [&](const fs::path&) -> StatusOr<SceneParts> {
    if (++made > 1) return SceneParts{.description = "{}", .parts = {}};
    begun.set_value();
    release.get_future().wait();
    return BadInputError("no scene yet");
  };
  Start();
  auto first = std::async(std::launch::async, [&] {
    httplib::Client client("127.0.0.1", port());
    client.set_read_timeout(60);
    const auto answer = client.Get("/api/scene");
    return answer ? answer->status : 0;
  });
  begun.get_future().wait();
  // More than there are connections.
  for (int i = 0; i < 5; ++i) {
    for (const char* path :
         {"/api/scene", "/api/parts/0/splats.spz", "/api/parts/0/labels.bin"}) {
      const auto answer = Get(path);
      EXPECT_TRUE(answer && answer->status == 429) << path;
      EXPECT_EQ(answer->get_header_value("Retry-After"), "1");
    }
  }
  EXPECT_EQ(GetJson("/api/status")["live"], true);
  EXPECT_EQ(made, 1);
  release.set_value();
  EXPECT_EQ(first.get(), 409);
  // What failed is tried again when it is asked for again.
  EXPECT_EQ(Get("/api/scene")->status, 200);
  EXPECT_EQ(Get("/api/scene")->status, 200);
  EXPECT_EQ(made, 2);
}

TEST_F(ViewApiTest, WithoutAViewerThereIsNoScene) {
  Start();
  for (const char* path : {"/api/scene", "/api/parts/0/splats.spz"}) {
    const auto answer = Get(path);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->status, 503);
    EXPECT_THAT(json::parse(answer->body)["error"].get<std::string>(),
                HasSubstr("viewer"));
  }
}

}  // namespace
}  // namespace freegs::stages
