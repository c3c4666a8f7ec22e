// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/model_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "semantics/clip/opencv_clip.h"
#include "tests/semantics/clip/model_files.h"
#include "tests/semantics/clip/token_table_file.h"

namespace freegs::semantics {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

// Every fault is a missing model, and its message says what to do.
void ExpectFault(const Status& status,
                 const std::string& file,
                 const std::string& fault) {
  EXPECT_EQ(status.code(), StatusCode::kMissingDependency);
  EXPECT_THAT(status.message(),
              AllOf(HasSubstr(file),
                    HasSubstr(fault),
                    HasSubstr("freegs_pipeline model")));
}

TEST(ModelFolderTest, ReadsTheModelItsTokenizerAndItsTokenTable) {
  const auto folder = ModelFolder::Open(TinyClip());
  ASSERT_TRUE(folder.ok()) << folder.status().message();
  const ModelInfo& info = folder->info;
  EXPECT_EQ(info.name, "tiny random model");
  EXPECT_EQ(info.embedding_dim, 8);
  EXPECT_EQ(info.image_size, 16);
  ASSERT_EQ(info.dense.size(), 2u);
  EXPECT_EQ(info.dense[1].file, "dense32.onnx");
  EXPECT_EQ(info.dense[1].grid, 4);
  EXPECT_FLOAT_EQ(info.mean[2], 0.40821073f);
  const auto tokenizer = folder->LoadTokenizer();
  ASSERT_TRUE(tokenizer.ok()) << tokenizer.status().message();
  EXPECT_EQ(tokenizer->vocab_size(), info.vocab_size);
  const auto table = folder->LoadTokenTable();
  ASSERT_TRUE(table.ok()) << table.status().message();
  EXPECT_EQ(table->columns(), info.text_width);
}

TEST(ModelFolderTest, EveryFileMustBeThereAndWhole) {
  for (const char* name : {"visual.onnx",
                           "dense.onnx",
                           "dense32.onnx",
                           "text.onnx",
                           "text_embedding",
                           "vocab",
                           "model.json"}) {
    const ModelCopy model;
    const std::string content = ReadText(model.path() / name);
    std::filesystem::remove(model.path() / name);
    ExpectFault(ModelFolder::Open(model.path()).status(), name, "no such file");
    std::filesystem::create_directory(model.path() / name);
    ExpectFault(
        ModelFolder::Open(model.path()).status(), name, "not a regular file");
    std::filesystem::remove(model.path() / name);
    WriteText(model.path() / name, content.substr(0, content.size() / 2));
    ExpectFault(ModelFolder::Open(model.path()).status(), name, "");
    std::string damaged = content;
    damaged[damaged.size() / 2] ^= 1;
    if (std::string(name) == "model.json") continue;
    WriteText(model.path() / name, damaged);
    ExpectFault(ModelFolder::Open(model.path()).status(), name, "content");
  }
  ExpectFault(ModelFolder::Open("/no/such/folder").status(),
              "/no/such/folder",
              "no such model folder");
}

TEST(ModelFolderTest, EveryFieldIsNeededAndChecked) {
  const json good = ModelCopy().Info();
  for (const auto& [key, value] : good.items()) {
    const ModelCopy model;
    json info = good;
    info.erase(key);
    model.SetInfo(info);
    ExpectFault(ModelFolder::Open(model.path()).status(), "model.json", key);
    for (const json& wrong : {json(nullptr),
                              json(-1),
                              json(1e300),
                              json("x"),
                              json::array(),
                              json({1, "x", 3}),
                              json::object()}) {
      // Words may be any words.
      if (value.is_string() && wrong.is_string() && key != "format") continue;
      info[key] = wrong;
      model.SetInfo(info);
      ExpectFault(ModelFolder::Open(model.path()).status(), "model.json", key);
    }
  }
}

TEST(ModelFolderTest, FilesStayInTheFolder) {
  for (const char* name : {"../visual.onnx", "/etc/passwd", "a/b", "", "."}) {
    const ModelCopy model;
    json info = model.Info();
    info["files"][name] = info["files"]["vocab"];
    model.SetInfo(info);
    ExpectFault(ModelFolder::Open(model.path()).status(),
                "model.json",
                "is not the name of a file");
  }
}

TEST(ModelFolderTest, DenseNetworksAreChecked) {
  for (const auto& [dense, fault] :
       std::initializer_list<std::pair<json, std::string>>{
           {json::array(), "dense"},
           {{{{"file", "other.onnx"}, {"image_size", 16}, {"grid", 2}}},
            "must be dense.onnx"},
           {{{{"file", "dense.onnx"}, {"image_size", 16}, {"grid", 17}}},
            "larger than the image"},
           {{{{"file", "dense.onnx"}, {"image_size", 16}}}, "grid: is missing"},
           {{1}, "dense"},
           {{{{"file", "dense.onnx"}, {"image_size", 16}, {"grid", 2}},
             {{"file", "new.onnx"}, {"image_size", 16}, {"grid", 2}}},
            "files.new.onnx: is missing"}}) {
    const ModelCopy model;
    json info = model.Info();
    info["dense"] = dense;
    model.SetInfo(info);
    ExpectFault(ModelFolder::Open(model.path()).status(), "model.json", fault);
  }
}

TEST(ModelFolderTest, VocabularyMayBeThere) {
  const ModelCopy model;
  EXPECT_TRUE(ModelFolder::Open(model.path())->info.vocabulary.empty());
  json info = model.Info();
  info["vocabulary"] = {{"red", "green"}, {"box"}};
  model.SetInfo(info);
  const auto folder = ModelFolder::Open(model.path());
  ASSERT_TRUE(folder.ok());
  EXPECT_EQ(folder->info.vocabulary,
            (std::vector<std::vector<std::string>>{{"red", "green"}, {"box"}}));
  for (const char* const wrong : {R"("red")",
                                  R"(["red"])",
                                  "[[]]",
                                  R"([["red", 1]])",
                                  R"([[""]])",
                                  R"([["x", ["y"]]])"}) {
    info["vocabulary"] = json::parse(wrong);
    model.SetInfo(info);
    ExpectFault(
        ModelFolder::Open(model.path()).status(), "model.json", "vocabulary");
  }
}

TEST(ModelFolderTest, CanonicalPhrasesMayBeThere) {
  const ModelCopy model;
  EXPECT_TRUE(ModelFolder::Open(model.path())->info.canonical.empty());
  EXPECT_EQ((*OpenCvClip::Open(model.path()))->canonical_phrases().size(), 4u);
  json info = model.Info();
  info["canonical"] = {"stuff", "some object"};
  model.SetInfo(info);
  const auto clip = OpenCvClip::Open(model.path());
  ASSERT_TRUE(clip.ok());
  EXPECT_EQ((*clip)->canonical_phrases(),
            (std::vector<std::string>{"stuff", "some object"}));
  for (const char* const wrong :
       {R"("stuff")", "[]", R"([["a", "b"]])", "[1]", R"([""])"}) {
    info["canonical"] = json::parse(wrong);
    model.SetInfo(info);
    ExpectFault(
        ModelFolder::Open(model.path()).status(), "model.json", "canonical");
  }
}

TEST(ModelFolderTest, ConfidenceOfWordsMayBeThere) {
  const ModelCopy model;
  EXPECT_EQ(ModelFolder::Open(model.path())->info.min_word_confidence, 0);
  json info = model.Info();
  info["min_word_confidence"] = 0.75;
  model.SetInfo(info);
  EXPECT_EQ(ModelFolder::Open(model.path())->info.min_word_confidence, 0.75);
  for (const json& wrong : {json(-0.1), json(1.5), json("high"), json()}) {
    info["min_word_confidence"] = wrong;
    model.SetInfo(info);
    ExpectFault(ModelFolder::Open(model.path()).status(),
                "model.json",
                "min_word_confidence");
  }
}

TEST(ModelFolderTest, HostileJson) {
  const ModelCopy model;
  for (const std::string& text : {std::string(),
                                  std::string("[]"),
                                  std::string("{"),
                                  std::string("\xff\xfe"),
                                  std::string(1 << 19, '['),
                                  std::string(3 << 20, ' ')}) {
    WriteText(model.path() / "model.json", text);
    ExpectFault(ModelFolder::Open(model.path()).status(), "model.json", "");
  }
}

TEST(ModelFolderTest, FilesMustFitTogether) {
  const ModelCopy model;
  model.Replace("vocab", "header\na b\n");
  const auto folder = ModelFolder::Open(model.path());
  ASSERT_TRUE(folder.ok()) << folder.status().message();
  ExpectFault(folder->LoadTokenizer().status(), "vocab", "515 tokens");
  model.Replace("vocab", "not merges");
  ExpectFault(folder->LoadTokenizer().status(), "vocab", "merges");
  model.Replace(
      "text_embedding",
      TokenTableFile(std::vector<float>(6), 3, 2, TokenNumbers::kFloat32));
  ExpectFault(
      folder->LoadTokenTable().status(), "text_embedding", "3 x 2 numbers");
  model.Replace("text_embedding", "x");
  ExpectFault(folder->LoadTokenTable().status(), "text_embedding", "table");
}

TEST(ModelFolderTest, HashIsOfWhatChangesResults) {
  const std::string hash = ModelFolder::Open(TinyClip())->info.Hash();
  const ModelCopy model;
  EXPECT_EQ(ModelFolder::Open(model.path())->info.Hash(), hash);
  json info = model.Info();
  info["licence"] = "another";
  info["note"] = "something new";
  model.SetInfo(info);
  EXPECT_EQ(ModelFolder::Open(model.path())->info.Hash(), hash);
  info["mean"][1] = 0.5;
  model.SetInfo(info);
  EXPECT_NE(ModelFolder::Open(model.path())->info.Hash(), hash);
  model.SetInfo(ModelCopy().Info());
  model.Replace("dense.onnx", "another network");
  EXPECT_NE(ModelFolder::Open(model.path())->info.Hash(), hash);
}

}  // namespace
}  // namespace freegs::semantics
