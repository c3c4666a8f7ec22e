// SPDX-License-Identifier: BSD-3-Clause

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "semantics/losses/instance_distillation_loss.h"
#include "semantics/losses/pixel_distillation_loss.h"
#include "tests/semantics/losses/gradient_check.h"

namespace freegs::semantics {
namespace {

constexpr int kChannels = 5;
constexpr size_t kSampleRows = 9;
const float kNan = std::numeric_limits<float>::quiet_NaN();

// sum_p |F_p - T_p|_1 / (C P) over the P rows that have a target.
double Reference(const std::vector<double>& features,
                 const std::vector<const float*>& targets) {
  double sum = 0;
  double total = 0;
  for (size_t p = 0; p < targets.size(); ++p) {
    if (!targets[p]) continue;
    total += 1;
    for (int c = 0; c < kChannels; ++c) {
      sum += std::abs(features[p * kChannels + c] - targets[p][c]);
    }
  }
  return sum / (total * kChannels);
}

class DistillationLosses : public testing::Test {
 protected:
  ThreadPool pool_{2};
  std::vector<float> decoded_ = RandomValues(kSampleRows * kChannels, 1);
  std::vector<float> gradients_ = std::vector<float>(decoded_.size(), 0.0f);
};

TEST_F(DistillationLosses, PixelGradientIsThatOfTheFormula) {
  const std::vector<float> targets = RandomValues(decoded_.size(), 2);
  std::vector<const float*> rows;
  for (size_t p = 0; p < kSampleRows; ++p)
    rows.push_back(&targets[p * kChannels]);
  std::vector<float> gradients(decoded_.size(), 1.0f);  // Added to.
  const StatusOr<double> loss = PixelDistillationLoss(
      decoded_, targets, kChannels, 3.0, pool_, gradients);
  ASSERT_TRUE(loss.ok()) << loss.status().message();
  EXPECT_NEAR(*loss, Reference(ToDouble(decoded_), rows), 1e-6);
  for (float& g : gradients) g -= 1;
  ExpectSameGradient(gradients,
                     CentralDifferences(
                         [&](const std::vector<double>& x) {
                           return 3.0 * Reference(x, rows);
                         },
                         ToDouble(decoded_)));
}

TEST_F(DistillationLosses, PixelLossOfEqualFeaturesIsZeroAndStill) {
  const StatusOr<double> loss = PixelDistillationLoss(
      decoded_, decoded_, kChannels, 1.0, pool_, gradients_);
  EXPECT_EQ(*loss, 0);
  EXPECT_TRUE(AllZero(gradients_));
}

TEST_F(DistillationLosses, NothingToCompareIsZero) {
  EXPECT_EQ(*PixelDistillationLoss({}, {}, kChannels, 1.0, pool_, {}), 0);
  EXPECT_EQ(*InstanceDistillationLoss({}, kChannels, {}, {}, 1.0, pool_, {}),
            0);
  const std::vector<int32_t> ids(kSampleRows, -1);
  EXPECT_EQ(*InstanceDistillationLoss(
                decoded_, kChannels, ids, {}, 1.0, pool_, gradients_),
            0);
  EXPECT_TRUE(AllZero(gradients_));
}

TEST_F(DistillationLosses, InstanceGradientIsThatOfTheFormula) {
  std::vector<float> table = RandomValues(4 * kChannels, 3);
  for (int c = 0; c < kChannels; ++c) table[2 * kChannels + c] = kNan;
  const std::vector<uint8_t> known = {1, 1, 0, 1};  // The NaN is not read.
  const std::vector<int32_t> ids = {0, 1, 3, -1, 2, 1, 3, -7, 0};
  std::vector<const float*> rows;
  for (const int32_t id : ids) {
    rows.push_back(id < 0 || !known[id] ? nullptr : &table[id * kChannels]);
  }
  std::vector<float> gradients(decoded_.size(), 0.0f);
  const StatusOr<double> loss = InstanceDistillationLoss(
      decoded_, kChannels, ids, {table, known}, 0.3, pool_, gradients);
  ASSERT_TRUE(loss.ok()) << loss.status().message();
  EXPECT_NEAR(*loss, Reference(ToDouble(decoded_), rows), 1e-6);
  ExpectSameGradient(gradients,
                     CentralDifferences(
                         [&](const std::vector<double>& x) {
                           return 0.3 * Reference(x, rows);
                         },
                         ToDouble(decoded_)));
  for (size_t p = 0; p < kSampleRows; ++p) {
    if (rows[p]) continue;
    EXPECT_TRUE(
        AllZero(std::span(gradients).subspan(p * kChannels, kChannels)));
  }
}

TEST_F(DistillationLosses, RefuseWhatDoesNotFit) {
  const auto refused = [](const StatusOr<double>& loss) {
    return loss.status().code() == StatusCode::kInvalidArgument;
  };
  std::vector<float> targets = RandomValues(decoded_.size(), 2);
  const auto pixel = [&](std::span<const float> target,
                         int channels,
                         std::span<float> gradients) {
    return PixelDistillationLoss(
        decoded_, target, channels, 1.0, pool_, gradients);
  };
  const std::span<const float> all = targets;
  const std::span<float> out = gradients_;
  EXPECT_TRUE(refused(pixel(all.first(5), kChannels, out)));
  EXPECT_TRUE(refused(pixel(all, 0, out)));
  EXPECT_TRUE(refused(pixel(all, 7, out)));
  EXPECT_TRUE(refused(pixel(all, kChannels, out.first(3))));
  targets[7] = kNan;
  EXPECT_TRUE(refused(pixel(all, kChannels, out)));
  for (const float g : gradients_) EXPECT_TRUE(std::isfinite(g));

  const std::vector<float> table = RandomValues(2 * kChannels, 3);
  const std::vector<uint8_t> known = {1, 1};
  std::vector<int32_t> ids(kSampleRows, 1);
  const auto instance = [&](std::span<const float> features,
                            std::span<const int32_t> of) {
    return InstanceDistillationLoss(
        decoded_, kChannels, of, {features, known}, 1.0, pool_, gradients_);
  };
  EXPECT_TRUE(instance(table, ids).ok());
  EXPECT_TRUE(refused(instance(std::span(table).first(7), ids)));
  EXPECT_TRUE(refused(instance(table, std::span(ids).first(4))));
  ids[4] = 2;
  EXPECT_TRUE(refused(instance(table, ids)));
  ids[4] = std::numeric_limits<int32_t>::max();
  EXPECT_TRUE(refused(instance(table, ids)));
}

TEST_F(DistillationLosses, AreTheSameBytesForAnyNumberOfThreads) {
  constexpr size_t kMany = 1000;
  const std::vector<float> decoded = RandomValues(kMany * kChannels, 4);
  const std::vector<float> targets = RandomValues(kMany * kChannels, 5);
  std::vector<double> losses;
  std::vector<std::vector<float>> results;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    std::vector<float> gradients(decoded.size(), 0.0f);
    losses.push_back(*PixelDistillationLoss(
        decoded, targets, kChannels, 1.0, pool, gradients));
    results.push_back(gradients);
  }
  for (size_t k = 1; k < losses.size(); ++k) {
    EXPECT_EQ(losses[k], losses[0]);
    EXPECT_EQ(results[k], results[0]);
  }
}

}  // namespace
}  // namespace freegs::semantics
