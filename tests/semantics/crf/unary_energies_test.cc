// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/crf/unary_energies.h"

#include <cmath>

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

TEST(UnaryEnergiesTest, OfLabels) {
  ImageU16 labels(3, 1, 1);
  labels(0, 0) = 1;
  labels(1, 0) = 0;
  labels(2, 0) = kUnknownLabel;
  const auto unary = UnaryFromLabels(labels, 5, 0.8);
  ASSERT_TRUE(unary.ok());
  ASSERT_EQ(unary->channels(), 5);
  for (int l = 0; l < 5; ++l) {
    EXPECT_NEAR((*unary)(0, 0, l), -std::log(l == 1 ? 0.8 : 0.05), 1e-6);
    EXPECT_NEAR((*unary)(1, 0, l), -std::log(l == 0 ? 0.8 : 0.05), 1e-6);
    EXPECT_NEAR((*unary)(2, 0, l), -std::log(0.2), 1e-6);
  }
  const auto single = UnaryFromLabels(ImageU16(2, 2, 1), 1, 0.8);
  ASSERT_TRUE(single.ok());
  EXPECT_EQ((*single)(1, 1), 0);
}

TEST(UnaryEnergiesTest, RefusesWhatMakesNoSense) {
  constexpr auto kRefused = StatusCode::kInvalidArgument;
  const ImageU16 labels(2, 2, 1, 3);
  EXPECT_EQ(UnaryFromLabels(ImageU16(), 2, 0.5).status().code(), kRefused);
  EXPECT_EQ(UnaryFromLabels(ImageU16(2, 2, 2), 2, 0.5).status().code(),
            kRefused);
  EXPECT_EQ(UnaryFromLabels(labels, 3, 0.5).status().code(), kRefused);
  EXPECT_EQ(UnaryFromLabels(labels, 0, 0.5).status().code(), kRefused);
  EXPECT_EQ(UnaryFromLabels(labels, 65536, 0.5).status().code(), kRefused);
  for (const double confidence : {0.0, 1.0, std::nan("")}) {
    EXPECT_EQ(UnaryFromLabels(labels, 4, confidence).status().code(), kRefused);
  }
}

}  // namespace
}  // namespace freegs::semantics
