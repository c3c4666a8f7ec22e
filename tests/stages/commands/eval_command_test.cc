// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/eval_command.h"

#include <cstdint>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/QR>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "pipeline/exit_code.h"
#include "semantics/clip/opencv_clip.h"
#include "semantics/clip/relevancy.h"
#include "semantics/field/idsf.h"
#include "semantics/losses/decoder_file.h"
#include "semantics/queries/instance_features.h"
#include "stages/scene/scene_instances.h"
#include "tests/semantics/clip/model_files.h"
#include "tests/stages/camera_json.h"
#include "tests/stages/synthetic_workspace.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using semantics::TinyClip;
using testing::HasSubstr;

// A workspace whose truth is its own rendering, instance 1 .. 3 being the
// objects named below.
class EvalCommandTest : public testing::Test {
 protected:
  const std::vector<std::string> kLabels = {
      "red apple", "wooden box", "blue mug"};

  void SetUp() override {
    workspace_.AddInstances();
    ThreadPool pool(2);
    json cameras = {{"intrinsics", IntrinsicsJson(workspace_.views[0].camera)}};
    for (const View& view : workspace_.views) {
      cameras["train"][view.name] = PoseJson(view.cam_from_world);
    }
    for (const size_t k : {size_t{0}, size_t{3}}) {
      const View& view = workspace_.views[k];
      const std::string name = "test" + std::to_string(k) + ".png";
      cameras["test"][name] = PoseJson(view.cam_from_world);
      const Image<int32_t> labels = splat::RenderLabels(workspace_.model,
                                                        view.camera,
                                                        view.cam_from_world,
                                                        {},
                                                        pool,
                                                        workspace_.labels);
      fs::create_directories(gt() / "instance");
      ASSERT_TRUE(
          WriteLabels(gt() / "instance" / name, EncodeInstances(labels)).ok());
    }
    json objects = {{"objects", json::array()}};
    for (size_t i = 0; i < kLabels.size(); ++i) {
      const semantics::AxisAlignedBox& box = workspace_.instances[i].aabb;
      const auto list = [](const Eigen::Vector3d& v) {
        return json::array({v.x(), v.y(), v.z()});
      };
      objects["objects"].push_back(
          {{"id", i + 1},
           {"label", kLabels[i]},
           {"aabb", {{"min", list(box.min)}, {"max", list(box.max)}}}});
    }
    ASSERT_TRUE(WriteFileAtomic(gt() / "cameras.json", cameras.dump()).ok());
    ASSERT_TRUE(WriteFileAtomic(gt() / "objects.json", objects.dump()).ok());
  }

  fs::path gt() const { return truth_.path() / "gt"; }

  static Eigen::VectorXf Encode(semantics::ClipEncoder* encoder,
                                const std::string& words) {
    const auto text = encoder->EncodeText(words);
    EXPECT_TRUE(text.ok());
    return Eigen::VectorXf::Map(text->values.data(),
                                static_cast<Eigen::Index>(text->values.size()));
  }

  // Instances that look to the tiny model like the words they are called by.
  void WriteFeatures(const std::string& hash = "") {
    const auto encoder = semantics::OpenCvClip::Open(TinyClip());
    ASSERT_TRUE(encoder.ok()) << encoder.status().message();
    semantics::InstanceFeatures features;
    features.dim = (*encoder)->embedding_dim();
    features.model = TinyClip().string();
    features.model_hash = hash.empty() ? (*encoder)->model_hash() : hash;
    // The random model finds all texts alike. Each feature is therefore the
    // vector that has nothing in common with any text but its own.
    std::vector<std::string> words = kLabels;
    for (const std::string& phrase : (*encoder)->canonical_phrases()) {
      words.push_back(phrase);
    }
    const auto count = static_cast<Eigen::Index>(words.size());
    Eigen::MatrixXf texts(count, features.dim);
    for (Eigen::Index i = 0; i < count; ++i) {
      texts.row(i) =
          Encode(encoder->get(), words[static_cast<size_t>(i)]).transpose();
    }
    const Eigen::MatrixXf duals =
        texts.completeOrthogonalDecomposition().pseudoInverse();
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(kLabels.size());
         ++i) {
      const Eigen::VectorXf feature = duals.col(i).normalized();
      features.features.insert(
          features.features.end(), feature.begin(), feature.end());
    }
    ASSERT_TRUE(semantics::WriteInstanceFeatures(
                    workspace_ / "bootstrap/instance_features.json", features)
                    .ok());
  }

  // Each Gaussian has the feature of its instance, or its first `dim` numbers.
  void WriteField(int dim) {
    const auto features = semantics::ReadInstanceFeatures(
        workspace_ / "bootstrap/instance_features.json");
    ASSERT_TRUE(features.ok()) << features.status().message();
    semantics::LinearDecoder linear;
    linear.latent_dim = static_cast<int>(kLabels.size());
    linear.feature_dim = dim;
    linear.mean.resize(static_cast<size_t>(dim));
    const auto whole = static_cast<size_t>(features->dim);
    for (size_t c = 0; c < linear.mean.size(); ++c) {
      for (size_t k = 0; k < kLabels.size(); ++k) {
        linear.basis.push_back(features->features[k * whole + c]);
      }
    }
    ASSERT_TRUE(
        semantics::WriteDecoder(
            workspace_ / "bootstrap/decoder.bin",
            {semantics::FeatureDecoder(std::move(linear)), std::nullopt})
            .ok());
    semantics::Idsf field;
    field.feature_dim = static_cast<int>(kLabels.size());
    field.instances = workspace_.labels;
    for (const int32_t label : workspace_.labels) {
      for (int32_t k = 0; k < field.feature_dim; ++k) {
        field.features.push_back(label == k ? 1.0f : 0.0f);
      }
    }
    ASSERT_TRUE(
        semantics::WriteIdsf(workspace_ / "bootstrap/idsf.bin", field).ok());
  }

  int Eval(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), workspace_.path().string());
    arguments.insert(arguments.end(), {"--json", "-"});
    output_.str("");
    messages_.str("");
    CommandContext context{output_, messages_, cancellation_, "freegs"};
    const Status status = RunEvalCommand(arguments, context);
    message_ = status.message();
    result_ = json::parse(output_.str(), nullptr, false);
    return pipeline::ExitCode(status.code());
  }

  SyntheticWorkspace workspace_;
  TemporaryFolder truth_;
  CancellationToken cancellation_;
  std::ostringstream output_;
  std::ostringstream messages_;
  std::string message_;
  json result_;
};

TEST_F(EvalCommandTest, AsksTheLabelsOfTheTruth) {
  WriteFeatures();
  ASSERT_EQ(Eval({"--gt", truth_.path().string()}), 0) << message_;
  EXPECT_GT(result_["instance_miou"], 0.95);
  EXPECT_GT(result_["text_miou"], 0.95);
  EXPECT_GT(result_["text_mbiou"], 0.95);
  EXPECT_GT(result_["text_box_miou"], 0.95);
  EXPECT_EQ(result_["text_box_recall50"], 1);
  EXPECT_GT(result_["pq"], 0.95);
  EXPECT_GT(result_["view_consistency"], 0);
  EXPECT_EQ(result_["text_model"], "tiny random model");
  EXPECT_TRUE(result_["text_threshold"].is_null());
  ASSERT_EQ(result_["labels"].size(), 3u);
  EXPECT_EQ(result_["labels"][0]["label"], "blue mug");
  EXPECT_EQ(result_["labels"][0]["instance"], 3);
}

TEST_F(EvalCommandTest, BelowTheThresholdThereIsNoAnswer) {
  WriteFeatures();
  ASSERT_EQ(Eval({"--gt", truth_.path().string(), "--text-threshold", "1"}), 0)
      << message_;
  EXPECT_EQ(result_["text_miou"], 0);
  EXPECT_EQ(result_["text_box_miou"], 0);
  EXPECT_EQ(result_["text_threshold"], 1);
  EXPECT_TRUE(result_["labels"][0]["instance"].is_null());
  EXPECT_GT(result_["labels"][0]["relevancy"], 0.5);
}

TEST_F(EvalCommandTest, WhenGaussiansAnswerNoInstanceDoes) {
  WriteFeatures();
  WriteField(8);
  ASSERT_EQ(Eval({"--gt", truth_.path().string(), "--text-from", "gaussians"}),
            0)
      << message_;
  EXPECT_EQ(result_["text_from"], "gaussians");
  EXPECT_EQ(result_["text_threshold"], 0.5);
  EXPECT_TRUE(result_["text_miou"].is_number());
  ASSERT_EQ(result_["labels"].size(), kLabels.size());
  for (const json& label : result_["labels"]) {
    EXPECT_TRUE(label["instance"].is_null());
    EXPECT_GT(label["relevancy"], 0.5);
  }
}

TEST_F(EvalCommandTest, TellsOnceOfALabelThatIsTooLong) {
  WriteFeatures();
  WriteField(8);
  std::string label = "blue";
  for (int i = 0; i < 100; ++i) label += " mug";
  json objects = json::parse(ReadText(gt() / "objects.json"));
  // Two objects share it.
  objects["objects"][1]["label"] = objects["objects"][2]["label"] = label;
  WriteText(gt() / "objects.json", objects.dump());
  for (const char* from : {"instances", "gaussians"}) {
    ASSERT_EQ(Eval({"--gt", truth_.path().string(), "--text-from", from}), 0)
        << message_;
    EXPECT_EQ(messages_.str(),
              "eval: label \"" + label +
                  "\" is too long for the model; it sees only its beginning\n")
        << from;
    EXPECT_EQ(result_["labels"].size(), 2u);
  }
}

TEST_F(EvalCommandTest, ADecoderOfOtherFeaturesIsNamed) {
  WriteFeatures();
  // Texts of 8 numbers can be divided into vectors of 4.
  WriteField(4);
  EXPECT_EQ(Eval({"--gt", truth_.path().string(), "--text-from", "gaussians"}),
            pipeline::ExitCode(StatusCode::kBadInput));
  EXPECT_THAT(message_, HasSubstr("decoder.bin gives features of 4 numbers"));
}

TEST_F(EvalCommandTest, SaysWhyThereIsNoText) {
  ASSERT_EQ(Eval({"--gt", truth_.path().string()}), 0) << message_;
  EXPECT_TRUE(result_["text_miou"].is_null());
  EXPECT_GT(result_["instance_miou"], 0.95);
  EXPECT_THAT(messages_.str(), HasSubstr("no figures of text"));
  EXPECT_THAT(messages_.str(), HasSubstr("instance_features.json"));
  const std::vector<std::string> of_gaussians = {
      "--gt", truth_.path().string(), "--text-from", "gaussians"};
  ASSERT_EQ(Eval(of_gaussians), 0) << message_;
  EXPECT_TRUE(result_["text_miou"].is_null());
  EXPECT_TRUE(result_["text_threshold"].is_null());
  EXPECT_THAT(messages_.str(), HasSubstr("no figures of text"));
  // Who asks for a model wants its figures.
  EXPECT_EQ(Eval({"--gt", truth_.path().string(), "--model", "nowhere"}), 5);
}

TEST_F(EvalCommandTest, AFileThatCannotBeWrittenIsBadInput) {
  CommandContext context{output_, messages_, cancellation_, "freegs"};
  const Status status = RunEvalCommand({workspace_.path().string(),
                                        "--json",
                                        (gt() / "cameras.json" / "a").string()},
                                       context);
  EXPECT_EQ(status.code(), StatusCode::kBadInput) << status.message();
  EXPECT_EQ(output_.str(), "");
}

TEST_F(EvalCommandTest, DevicesAreRefusedWithAdvice) {
  CommandContext context{output_, messages_, cancellation_, "freegs"};
  const Status status = RunEvalCommand(
      {workspace_.path().string(), "--json", "/dev/null"}, context);
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_EQ(status.message(),
            "/dev/null: not a regular file; give a file, or - for standard "
            "output");
}

TEST_F(EvalCommandTest, RefusesFeaturesOfAnotherModel) {
  WriteFeatures("another");
  ASSERT_EQ(Eval({"--gt", truth_.path().string()}), 0) << message_;
  EXPECT_TRUE(result_["text_miou"].is_null());
  EXPECT_THAT(messages_.str(), HasSubstr("another model"));
}

TEST_F(EvalCommandTest, MeasuresConsistencyWithoutTruth) {
  ASSERT_EQ(Eval({}), 0) << message_;
  EXPECT_GT(result_["view_consistency"], 0);
  EXPECT_TRUE(result_["pq"].is_null());
}

TEST_F(EvalCommandTest, TheLayoutMustFit) {
  const std::string truth = truth_.path().string();
  EXPECT_EQ(Eval({"--gt", truth, "--layout", "scene"}), 0) << message_;
  EXPECT_EQ(Eval({"--gt", truth, "--layout", "3dovs"}), 3);
  EXPECT_EQ(Eval({"--gt", truth, "--layout", "kitti"}), 2);
}

}  // namespace
}  // namespace freegs::stages
