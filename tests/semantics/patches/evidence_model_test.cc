// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/evidence_model.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

std::string Text(const std::string& last_name, const std::string& deviation) {
  std::string text = R"({"bias": -1, "evidence": [)";
  for (size_t k = 0; k < kNumEvidences; ++k) {
    const bool last = k + 1 == kNumEvidences;
    text += R"({"name": ")" + (last ? last_name : kEvidenceNames[k]) +
            R"(", "mean": 0.5, "deviation": )" + (last ? deviation : "2") +
            R"(, "weight": )" + (k == 0 ? "3" : "0") + "}" +
            (last ? "]}" : ",");
  }
  return text;
}

TEST(EvidenceModelTest, AddsWeightedEvidence) {
  const auto model = ParseEvidenceModel(Text("semantics", "2"));
  ASSERT_TRUE(model.ok()) << model.status().message();
  Evidence evidence = {};
  evidence[kContrastNear] = 1;
  EXPECT_NEAR(model->Difference(evidence), -1 + 3 * 0.5 / 2, 1e-9);
}

TEST(EvidenceModelTest, TheOneThatShipsIsReadable) {
  const auto model = DefaultEvidenceModel();
  ASSERT_TRUE(model.ok()) << model.status().message();
  EXPECT_TRUE(std::isfinite(model->Difference({})));
}

TEST(EvidenceModelTest, RefusesDamagedFiles) {
  for (const std::string& text : {std::string(),
                                  std::string("{}"),
                                  std::string("[1, 2]"),
                                  std::string(R"({"bias": 1, "evidence": []})"),
                                  Text("smell", "2"),
                                  Text("contrast_near", "2"),
                                  Text("semantics", "0"),
                                  Text("semantics", "-1"),
                                  Text("semantics", "1e400"),
                                  Text("semantics", "\"2\"")}) {
    EXPECT_EQ(ParseEvidenceModel(text).status().code(), StatusCode::kBadInput)
        << text;
  }
  const std::string whole = Text("semantics", "2");
  for (size_t length = 0; length < whole.size(); length += 37) {
    EXPECT_FALSE(ParseEvidenceModel(whole.substr(0, length)).ok());
  }
}

}  // namespace
}  // namespace freegs::semantics
