// SPDX-License-Identifier: BSD-3-Clause
// A tiny CLIP goes through the whole export and is run by the encoder; a
// forward pass in double precision says what should come out.

#include "semantics/clip_export/clip_export.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/Core>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "semantics/clip/opencv_clip.h"
#include "semantics/clip_export/clip_networks.h"
#include "tests/semantics/clip/model_files.h"
#include "tests/semantics/clip_export/random_clip.h"
#include "tests/semantics/clip_export/reference_clip.h"

namespace freegs::semantics {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::FloatNear;
using testing::HasSubstr;
using testing::Pointwise;

class ClipExportTest : public testing::Test {
 protected:
  fs::path source() const { return folder_ / "source"; }
  fs::path out() const { return folder_ / "out"; }

  Status Export(int dense_size = 0) const {
    return ExportClip(
               {.checkpoint = source(), .merges = {}, .dense_size = dense_size},
               out(),
               nullptr)
        .status();
  }

  // The export must fail, must name the file, and must leave nothing.
  void ExpectFault(const std::string& file, const std::string& fault) const {
    const Status status = Export();
    EXPECT_EQ(status.code(), StatusCode::kMissingDependency) << fault;
    EXPECT_THAT(status.message(), AllOf(HasSubstr(file), HasSubstr(fault)));
    EXPECT_FALSE(fs::exists(out()));
    EXPECT_FALSE(fs::exists(folder_ / "out.part"));
  }

  const TemporaryFolder folder_;
  const RandomClip clip_;
};

ImageU8 RandomPhoto(int size) {
  RandomStream random(9, 1);
  ImageU8 image(size, size, 3);
  for (size_t i = 0; i < image.size(); ++i) {
    image.data()[i] = static_cast<uint8_t>(random.Index(256));
  }
  return image;
}

// A row of colours for each patch, channel by channel.
ReferenceClip::Matrix PatchesOf(const ImageU8& image, const ModelInfo& info) {
  constexpr int kPatch = RandomClip::kPatch;
  const int grid = image.width() / kPatch;
  ReferenceClip::Matrix patches(grid * grid, 3 * kPatch * kPatch);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        const size_t place = (y % kPatch) * kPatch + x % kPatch;
        const size_t pixel = static_cast<size_t>(y) * image.width() + x;
        patches(y / kPatch * grid + x / kPatch, c * kPatch * kPatch + place) =
            (image.data()[3 * pixel + c] / 255.0 - info.mean[c]) / info.std[c];
      }
    }
  }
  return patches;
}

ReferenceClip::Matrix PositionsFor(const RandomClip& clip, int grid) {
  const std::vector<float> positions =
      ResizePositions(clip.tensors().at("visual.positional_embedding").values,
                      RandomClip::kWidth,
                      RandomClip::kImageSize / RandomClip::kPatch,
                      grid);
  ReferenceClip::Matrix rows(grid * grid + 1, RandomClip::kWidth);
  for (size_t i = 0; i < positions.size(); ++i) rows.data()[i] = positions[i];
  return rows;
}

void ExpectSameNumbers(const float* values,
                       const ReferenceClip::Matrix& reference) {
  const double scale = reference.cwiseAbs().maxCoeff();
  ASSERT_GT(scale, 0.01);
  for (int i = 0; i < reference.size(); ++i) {
    ASSERT_NEAR(values[i], reference.data()[i], 1e-5 * scale) << i;
  }
}

void CompareWithReference(const fs::path& folder,
                          const RandomClip& clip,
                          bool quick_gelu) {
  const auto opened = OpenCvClip::Open(folder);
  ASSERT_TRUE(opened.ok()) << opened.status().message();
  OpenCvClip& encoder = **opened;
  const ReferenceClip reference(clip.tensors(), quick_gelu);

  const ImageU8 image = RandomPhoto(RandomClip::kImageSize);
  const auto vector = encoder.EncodeImage(image);
  ASSERT_TRUE(vector.ok()) << vector.status().message();
  ExpectSameNumbers(
      vector->data(),
      reference
          .Image(PatchesOf(image, encoder.info()), PositionsFor(clip, 2), false)
          .normalized());

  EXPECT_THAT(encoder.dense_sizes(), ElementsAre(16, 32));
  for (const int size : {16, 32}) {
    const ImageU8 square = RandomPhoto(size);
    const auto dense = encoder.EncodeDense(square, size);
    ASSERT_TRUE(dense.ok()) << dense.status().message();
    ASSERT_EQ(dense->width(), size / RandomClip::kPatch);
    ExpectSameNumbers(dense->data(),
                      reference.Image(PatchesOf(square, encoder.info()),
                                      PositionsFor(clip, dense->width()),
                                      true));
  }

  // "red" is one piece: start, red, end. The table is in half precision.
  const auto text = encoder.EncodeText("red");
  ASSERT_TRUE(text.ok()) << text.status().message();
  const ReferenceClip::Matrix table =
      reference.Get("token_embedding.weight").unaryExpr([](double value) {
        return static_cast<double>(Eigen::half(static_cast<float>(value)));
      });
  ReferenceClip::Matrix tokens(3, RandomClip::kTextWidth);
  tokens << table.row(514), table.row(513), table.row(515);
  ExpectSameNumbers(text->values.data(), reference.Text(tokens).normalized());
}

TEST_F(ClipExportTest, HuggingFaceGivesTheSameNumbers) {
  clip_.WriteHuggingFace(source(), "quick_gelu");
  const auto info = ExportClip(
      {.checkpoint = source(), .merges = {}, .dense_size = 32}, out(), nullptr);
  ASSERT_TRUE(info.ok()) << info.status().message();
  EXPECT_EQ(info->embedding_dim, RandomClip::kDim);
  EXPECT_EQ(info->context_length, RandomClip::kContext);
  EXPECT_FLOAT_EQ(info->mean[0], 0.48145466f);
  EXPECT_THAT(info->origin, HasSubstr("model.safetensors"));
  CompareWithReference(out(), clip_, true);
}

TEST_F(ClipExportTest, GeluIsAnotherActivation) {
  clip_.WriteHuggingFace(source(), "gelu");
  ASSERT_TRUE(Export(32).ok());
  CompareWithReference(out(), clip_, false);
}

TEST_F(ClipExportTest, BothLayoutsGiveTheSameFiles) {
  for (const char* activation : {"quick_gelu", "gelu"}) {
    clip_.WriteHuggingFace(folder_ / "a", activation);
    clip_.WriteOpenClip(folder_ / "b", activation);
    for (const char* name : {"a", "b"}) {
      const auto info = ExportClip(
          {.checkpoint = folder_ / name, .merges = {}, .dense_size = 32},
          folder_ / (std::string(name) + "_out"),
          nullptr);
      ASSERT_TRUE(info.ok()) << info.status().message();
    }
    for (const char* name : {"visual.onnx",
                             "dense.onnx",
                             "dense32.onnx",
                             "text.onnx",
                             "text_embedding",
                             "vocab"}) {
      const std::string bytes = ReadText(folder_ / "a_out" / name);
      EXPECT_GT(bytes.size(), 10u) << name;
      EXPECT_TRUE(bytes == ReadText(folder_ / "b_out" / name)) << name;
    }
  }
}

TEST_F(ClipExportTest, BothLayoutsNameTheEpsilonOfNorms) {
  nlohmann::json a = RandomClip::HuggingFaceConfig("gelu");
  a["vision_config"]["layer_norm_eps"] = 1e-2;
  a["text_config"]["layer_norm_eps"] = 1e-3;
  nlohmann::json b = RandomClip::OpenClipConfig("gelu");
  b["model_cfg"]["vision_cfg"]["norm_kwargs"] = {{"eps", 1e-2}};
  b["model_cfg"]["text_cfg"]["norm_kwargs"] = {{"eps", 1e-3}};
  // These say what is so without them.
  b["model_cfg"]["vision_cfg"]["pool_type"] = "tok";
  b["model_cfg"]["vision_cfg"]["act_kwargs"] = nullptr;
  b["model_cfg"]["text_cfg"]["pool_type"] = "argmax";
  b["model_cfg"]["text_cfg"]["act_kwargs"] = nlohmann::json::object();
  b["model_cfg"]["text_cfg"]["no_causal_mask"] = false;
  clip_.WriteHuggingFace(folder_ / "a", "gelu");
  clip_.WriteOpenClip(folder_ / "b", "gelu");
  WriteText(folder_ / "a/config.json", a.dump());
  WriteText(folder_ / "b/open_clip_config.json", b.dump());
  for (const char* name : {"a", "b"}) {
    const auto info = ExportClip({.checkpoint = folder_ / name},
                                 folder_ / (std::string(name) + "_out"),
                                 nullptr);
    ASSERT_TRUE(info.ok()) << info.status().message();
  }
  clip_.WriteHuggingFace(source(), "gelu");
  ASSERT_TRUE(Export().ok());
  for (const char* name : {"visual.onnx", "dense.onnx", "text.onnx"}) {
    const std::string bytes = ReadText(folder_ / "a_out" / name);
    EXPECT_TRUE(bytes == ReadText(folder_ / "b_out" / name)) << name;
    EXPECT_FALSE(bytes == ReadText(out() / name)) << name;
  }
}

void ExpectNear(std::span<const float> values, std::span<const float> others) {
  ASSERT_EQ(values.size(), others.size());
  float largest = 0;
  for (const float value : others) {
    largest = std::max(largest, std::abs(value));
  }
  for (size_t i = 0; i < values.size(); ++i) {
    ASSERT_NEAR(values[i], others[i], 1e-6 * largest) << i;
  }
}

// TinyClip() was made of the same numbers by scripts/export_clip.py.
TEST_F(ClipExportTest, TheScriptGivesTheSameNumbers) {
  const auto info =
      ExportClip({.checkpoint = TinyClip().parent_path() / "tiny_checkpoint",
                  .merges = TinyClip() / "vocab",
                  .dense_size = 32},
                 out(),
                 nullptr);
  ASSERT_TRUE(info.ok()) << info.status().message();
  const auto ours = OpenCvClip::Open(out());
  const auto theirs = OpenCvClip::Open(TinyClip());
  ASSERT_TRUE(ours.ok()) << ours.status().message();
  ASSERT_TRUE(theirs.ok()) << theirs.status().message();
  const ImageU8 image = RandomPhoto(32);
  const auto vector = (*ours)->EncodeImage(image);
  const auto other_vector = (*theirs)->EncodeImage(image);
  ASSERT_TRUE(vector.ok() && other_vector.ok());
  ExpectNear(*vector, *other_vector);
  for (const int size : {16, 32}) {
    const auto dense = (*ours)->EncodeDense(image, size);
    const auto other_dense = (*theirs)->EncodeDense(image, size);
    ASSERT_TRUE(dense.ok() && other_dense.ok()) << size;
    ExpectNear({dense->data(), dense->size()},
               {other_dense->data(), other_dense->size()});
  }
  const auto text = (*ours)->EncodeText("a photo of a red apple");
  const auto other_text = (*theirs)->EncodeText("a photo of a red apple");
  ASSERT_TRUE(text.ok() && other_text.ok());
  ExpectNear(text->values, other_text->values);
}

TEST_F(ClipExportTest, ColoursMayStandBesideTheWeights) {
  clip_.WriteHuggingFace(source(), "gelu");
  WriteText(source() / "preprocessor_config.json",
            R"({"image_mean":[0.5,0.25,0.125],"image_std":[1,1,0.5]})");
  const auto info =
      ExportClip({.checkpoint = source() / "model.safetensors"}, out(), {});
  ASSERT_TRUE(info.ok()) << info.status().message();
  EXPECT_THAT(info->mean, ElementsAre(0.5f, 0.25f, 0.125f));
  EXPECT_THAT(info->std, ElementsAre(1.0f, 1.0f, 0.5f));
}

// The numbers are those of PyTorch 1.13.
TEST_F(ClipExportTest, PositionsAreResizedAsPyTorchDoes) {
  EXPECT_THAT(ResizePositions({9, 1, 2, 3, 5}, 1, 2, 3),
              Pointwise(FloatNear(1e-6f),
                        {9.0f,
                         0.7471188f,
                         1.2829863f,
                         1.8188541f,
                         1.8697921f,
                         2.75f,
                         3.6302083f,
                         2.9924653f,
                         4.2170138f,
                         5.4415631f}));
  EXPECT_THAT(
      ResizePositions({9, 1, 2, 0, 3, 5, -4, 2, 2, 7}, 1, 3, 2),
      Pointwise(FloatNear(1e-6f),
                {9.0f, 1.9254761f, -0.3234253f, 2.3518829f, 4.0259247f}));
}

TEST_F(ClipExportTest, AModelFolderMayBeReplaced) {
  clip_.WriteHuggingFace(source(), "gelu");
  ASSERT_TRUE(Export(32).ok());
  // What a stopped export left does not matter.
  WriteText(folder_ / "out.part" / "text.onnx.part", "x");
  ASSERT_TRUE(Export().ok());
  EXPECT_FALSE(fs::exists(out() / "dense32.onnx"));
  EXPECT_FALSE(fs::exists(folder_ / "out.part"));
  EXPECT_FALSE(fs::exists(folder_ / "out.replaced.part"));
  EXPECT_TRUE(ModelFolder::Open(out()).ok());
}

// An export that was killed while it replaced a model leaves OUT.replaced.part:
// whole, or a part of it.
TEST_F(ClipExportTest, AnOldModelIsNotInTheWay) {
  clip_.WriteHuggingFace(source(), "gelu");
  const fs::path old = folder_ / "out.replaced.part";
  ASSERT_TRUE(Export().ok());
  fs::copy(out(), folder_ / "out.old");
  fs::rename(out(), old);
  ASSERT_TRUE(Export().ok());
  EXPECT_TRUE(ModelFolder::Open(out()).ok());
  EXPECT_TRUE(ModelFolder::Open(old).ok()) << "There was none to replace.";
  ASSERT_TRUE(Export(32).ok());
  EXPECT_TRUE(fs::exists(out() / "dense32.onnx"));
  EXPECT_FALSE(fs::exists(old));
  WriteText(old / "visual.onnx", "x");
  ASSERT_TRUE(Export().ok());
  EXPECT_TRUE(ModelFolder::Open(out()).ok());
  EXPECT_FALSE(fs::exists(old));
  // What somebody else put there is not removed, and is found at the start.
  WriteText(old / "diary.txt", "x");
  EXPECT_EQ(Export().code(), StatusCode::kBadInput);
  EXPECT_TRUE(fs::exists(old / "diary.txt"));
  EXPECT_TRUE(ModelFolder::Open(out()).ok());
  EXPECT_TRUE(ModelFolder::Open(folder_ / "out.old").ok()) << "A user's copy.";
}

TEST_F(ClipExportTest, OtherFoldersStay) {
  clip_.WriteHuggingFace(source(), "gelu");
  fs::create_directory(out());
  ASSERT_TRUE(Export().ok()) << "An empty folder is taken.";
  fs::remove_all(out());
  WriteText(out() / "model.json", R"({"format":"mine"})");
  EXPECT_EQ(Export().code(), StatusCode::kBadInput);
  EXPECT_TRUE(fs::exists(out() / "model.json"));
  fs::remove_all(out());
  WriteText(folder_ / "out.part" / "diary.txt", "x");
  EXPECT_EQ(Export().code(), StatusCode::kBadInput);
  EXPECT_TRUE(fs::exists(folder_ / "out.part" / "diary.txt"));
  WriteText(out(), "a file");
  EXPECT_EQ(Export().code(), StatusCode::kBadInput);
}

TEST_F(ClipExportTest, DenseSizesMustFit) {
  clip_.WriteHuggingFace(source(), "gelu");
  EXPECT_EQ(Export(30).code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(Export(-8).code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(Export(1 << 20).code(), StatusCode::kInvalidArgument);
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(ClipExportTest, StopsWhenAsked) {
  clip_.WriteHuggingFace(source(), "gelu");
  CancellationToken cancellation;
  cancellation.Cancel();
  const auto info = ExportClip({.checkpoint = source()}, out(), &cancellation);
  EXPECT_EQ(info.status().code(), StatusCode::kInterrupted);
  EXPECT_FALSE(fs::exists(out()));
  EXPECT_FALSE(fs::exists(folder_ / "out.part"));
}

TEST_F(ClipExportTest, PickledFilesAreNotRead) {
  for (const char* name : {"a.pt", "a.pth", "a.bin", "a.ckpt"}) {
    const auto info =
        ExportClip({.checkpoint = folder_ / name}, out(), nullptr);
    EXPECT_EQ(info.status().code(), StatusCode::kMissingDependency);
    EXPECT_THAT(info.status().message(),
                AllOf(HasSubstr(name),
                      HasSubstr(".safetensors"),
                      HasSubstr("export_clip.py")));
  }
  fs::create_directory(source());
  WriteText(source() / "pytorch_model.bin", "x");
  ExpectFault("source", "model.safetensors");
}

TEST_F(ClipExportTest, EveryTensorMustBeThereWithItsShape) {
  for (const bool open_clip : {false, true}) {
    fs::remove_all(source());
    open_clip ? clip_.WriteOpenClip(source(), "gelu")
              : clip_.WriteHuggingFace(source(), "gelu");
    const std::string file =
        open_clip ? "open_clip_model.safetensors" : "model.safetensors";
    const TestTensors good =
        open_clip ? clip_.tensors() : clip_.HuggingFaceTensors();
    for (const auto& [name, tensor] : good) {
      if (name == "logit_scale") continue;
      TestTensors bad = good;
      bad.erase(name);
      WriteText(source() / file, SafetensorsBytes(bad));
      ExpectFault(file, "");
      bad[name] = {{1, 1}, {1}};
      WriteText(source() / file, SafetensorsBytes(bad));
      ExpectFault(file, "");
    }
    TestTensors more = good;
    more["visual.attn_pool.query"] = {{1}, {1}};
    WriteText(source() / file, SafetensorsBytes(more));
    ExpectFault(file, "visual.attn_pool.query");
  }
}

TEST_F(ClipExportTest, FilesBesideTheWeightsMustFit) {
  clip_.WriteHuggingFace(source(), "gelu");
  const auto expect_config = [&](const nlohmann::json& config,
                                 const std::string& file,
                                 const std::string& fault) {
    WriteText(source() / "config.json", config.dump());
    ExpectFault(file, fault);
  };
  const nlohmann::json good = RandomClip::HuggingFaceConfig("gelu");
  nlohmann::json bad = good;
  bad["vision_config"]["hidden_act"] = "relu";
  expect_config(bad, "config.json", "relu");
  bad = good;
  bad["vision_config"]["num_attention_heads"] = 5;
  expect_config(bad, "model.safetensors", "5 heads");
  bad = good;
  bad["vision_config"]["patch_size"] = 16;
  expect_config(bad, "model.safetensors", "a patch of 8");
  bad = good;
  bad["text_config"]["num_hidden_layers"] = 12;
  expect_config(bad, "model.safetensors", "layers");
  bad = good;
  bad["model_type"] = "siglip";
  expect_config(bad, "config.json", "model_type");
  bad = good;
  bad["text_config"] = 3;
  expect_config(bad, "config.json", "text_config");
  WriteText(source() / "config.json", std::string(1000, '['));
  ExpectFault("config.json", "nested deeper");
  fs::remove(source() / "config.json");
  ExpectFault("config.json", "no such file");

  clip_.WriteHuggingFace(source(), "gelu");
  WriteText(source() / "merges.txt", "#version: 0.2\nr e\n");
  ExpectFault("merges.txt", "makes 515 tokens");
  WriteText(source() / "merges.txt", "#version: 0.2\nr e d\n");
  ExpectFault("merges.txt", "");
  fs::remove(source() / "merges.txt");
  ExpectFault("merges.txt", "--merges");
}

TEST_F(ClipExportTest, OpenClipsConfigMustFit) {
  clip_.WriteOpenClip(source(), "gelu");
  nlohmann::json bad = RandomClip::OpenClipConfig("gelu");
  bad["model_cfg"]["vision_cfg"]["head_width"] = 5;
  WriteText(source() / "open_clip_config.json", bad.dump());
  ExpectFault("open_clip_config.json", "head_width");
  const auto expect_refused =
      [&](const char* tower, const char* key, const nlohmann::json& value) {
        bad = RandomClip::OpenClipConfig("gelu");
        bad["model_cfg"][tower][key] = value;
        WriteText(source() / "open_clip_config.json", bad.dump());
        ExpectFault("open_clip_config.json",
                    "model_cfg." + std::string(tower) + "." + key);
      };
  expect_refused("vision_cfg", "pool_type", "avg");
  expect_refused("text_cfg", "pool_type", "last");
  expect_refused("text_cfg", "no_causal_mask", true);
  for (const char* tower : {"vision_cfg", "text_cfg"}) {
    expect_refused(tower, "act_kwargs", {{"approximate", "tanh"}});
    expect_refused(tower, "norm_kwargs", {{"eps", 0}});
  }
  WriteText(source() / "open_clip_config.json", "{}");
  ExpectFault("open_clip_config.json", "model_cfg");
  fs::remove(source() / "open_clip_config.json");
  ExpectFault("open_clip_config.json", "no such file");
}

}  // namespace
}  // namespace freegs::semantics
