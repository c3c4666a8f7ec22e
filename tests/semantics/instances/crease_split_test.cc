// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/crease_split.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::semantics {
namespace {

// Points on spheres, with outward normals. One cluster: all labels are 0.
struct Cloud {
  std::vector<float> positions;
  std::vector<float> colors;
  std::vector<float> normals;
  std::vector<int32_t> labels;
  std::vector<Eigen::Vector3d> centers;
  std::vector<double> radii;

  // Colour `upper` above the centre, `lower` below. Points inside spheres added
  // before are left out, as they would not be seen.
  void AddSphere(const Eigen::Vector3d& center,
                 double radius,
                 const Eigen::Vector3d& upper,
                 const Eigen::Vector3d& lower) {
    for (int i = 0; i < 3000; ++i) {
      const uint64_t stream = centers.size();
      Eigen::Vector3d normal;
      for (int k = 0; k < 3; ++k) {
        normal[k] = RandomNormal(5, stream, 3 * i + k);
      }
      normal.normalize();
      const Eigen::Vector3d position = center + radius * normal;
      bool hidden = false;
      for (size_t s = 0; s < centers.size(); ++s) {
        hidden = hidden || (position - centers[s]).norm() < radii[s];
      }
      if (hidden) continue;
      const Eigen::Vector3d& color = normal.z() > 0 ? upper : lower;
      for (int k = 0; k < 3; ++k) {
        positions.push_back(static_cast<float>(position[k]));
        colors.push_back(static_cast<float>(color[k]));
        normals.push_back(static_cast<float>(normal[k]));
      }
      labels.push_back(0);
    }
    centers.push_back(center);
    radii.push_back(radius);
  }

  int Split(const CreaseSplitOptions& options) {
    ThreadPool pool(2);
    SplitAtCreases(positions, colors, normals, options, pool, &labels);
    return static_cast<int>(
        std::set<int32_t>(labels.begin(), labels.end()).size());
  }
};

const Eigen::Vector3d kRed(0.8, 0.2, 0.2);
const Eigen::Vector3d kBlue(0.2, 0.2, 0.8);

CreaseSplitOptions Options() {
  return {.min_contrast = 0.12, .patch_size = 0.15, .min_part_size = 200};
}

TEST(CreaseSplitTest, BallsOfTwoColoursThatTouchAreTwo) {
  Cloud cloud;
  cloud.AddSphere({0, 0, 0}, 0.5, kRed, kRed);
  const size_t first = cloud.labels.size();
  cloud.AddSphere({0, 0, 0.7}, 0.35, kBlue, kBlue);
  EXPECT_EQ(cloud.Split(Options()), 2);
  int wrong = 0;
  for (size_t i = 0; i < cloud.labels.size(); ++i) {
    wrong += cloud.labels[i] != (i < first ? 0 : 1);
  }
  EXPECT_LT(wrong, static_cast<int>(cloud.labels.size()) / 50);
}

TEST(CreaseSplitTest, BallsOfOneColourStayTogether) {
  Cloud cloud;
  cloud.AddSphere({0, 0, 0}, 0.5, kRed, kRed);
  cloud.AddSphere({0, 0, 0.7}, 0.35, kRed, kRed);
  EXPECT_EQ(cloud.Split(Options()), 1);
}

TEST(CreaseSplitTest, ABallOfTwoColoursStaysTogether) {
  Cloud cloud;
  cloud.AddSphere({0, 0, 0}, 0.5, kRed, kBlue);
  EXPECT_EQ(cloud.Split(Options()), 1);
}

TEST(CreaseSplitTest, OtherClustersAndNoiseAreLeftAlone) {
  Cloud cloud;
  cloud.AddSphere({0, 0, 0}, 0.5, kRed, kRed);
  const size_t first = cloud.labels.size();
  cloud.AddSphere({0, 0, 0.7}, 0.35, kBlue, kBlue);
  for (size_t i = first; i < cloud.labels.size(); ++i) cloud.labels[i] = 3;
  cloud.labels[10] = -1;
  const std::vector<int32_t> before = cloud.labels;
  EXPECT_EQ(cloud.Split(Options()), 3);
  EXPECT_EQ(cloud.labels, before);
}

TEST(CreaseSplitTest, SwitchedOff) {
  Cloud cloud;
  cloud.AddSphere({0, 0, 0}, 0.5, kRed, kRed);
  cloud.AddSphere({0, 0, 0.7}, 0.35, kBlue, kBlue);
  CreaseSplitOptions options = Options();
  options.min_contrast = 0;
  EXPECT_EQ(cloud.Split(options), 1);
}

TEST(CreaseSplitTest, DegenerateInput) {
  ThreadPool pool(1);
  std::vector<int32_t> none;
  SplitAtCreases({}, {}, {}, Options(), pool, &none);
  EXPECT_TRUE(none.empty());
  // All in one place, without normals.
  const std::vector<float> zeros(3 * 1000, 0.0f);
  std::vector<int32_t> labels(1000, 0);
  SplitAtCreases(zeros, zeros, zeros, Options(), pool, &labels);
  EXPECT_EQ(labels, std::vector<int32_t>(1000, 0));
}

TEST(CreaseSplitTest, ChecksOptions) {
  EXPECT_TRUE(CreaseSplitOptions().Check().ok());
  EXPECT_FALSE(CreaseSplitOptions{.min_contrast = -1}.Check().ok());
  EXPECT_FALSE(CreaseSplitOptions{.patch_size = 0}.Check().ok());
  EXPECT_FALSE(CreaseSplitOptions{.min_part_size = 0}.Check().ok());
}

}  // namespace
}  // namespace freegs::semantics
