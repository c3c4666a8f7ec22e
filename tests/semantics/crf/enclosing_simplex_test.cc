// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/crf/enclosing_simplex.h"

#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::semantics {
namespace {

// A vertex's coordinates, the last one too.
std::vector<int32_t> Vertex(const EnclosingSimplex& simplex,
                            int dim,
                            int remainder) {
  std::vector<int32_t> vertex(dim);
  simplex.VertexKey(dim, remainder, vertex.data());
  vertex.push_back(-std::accumulate(vertex.begin(), vertex.end(), 0));
  return vertex;
}

TEST(EnclosingSimplexTest, VerticesAreOfTheLatticeAndEncloseThePoint) {
  for (const int dim : {1, 2, 3, 5, 8, kMaxLatticeDim}) {
    const SimplexLocator locator(dim);
    for (int trial = 0; trial < 500; ++trial) {
      std::vector<float> feature(dim);
      for (int i = 0; i < dim; ++i) {
        feature[i] = static_cast<float>(10 * RandomNormal(dim, i, trial));
      }
      std::vector<double> elevated(dim + 1);
      locator.Elevate(feature.data(), elevated.data());
      EnclosingSimplex simplex;
      locator.Locate(feature.data(), &simplex);
      double weights = 0;
      std::vector<double> mean(dim + 1, 0.0);
      for (int k = 0; k <= dim; ++k) {
        EXPECT_GE(simplex.weights[k], 0);
        weights += simplex.weights[k];
        const std::vector<int32_t> vertex = Vertex(simplex, dim, k);
        for (int i = 0; i <= dim; ++i) {
          EXPECT_EQ(((vertex[i] - k) % (dim + 1)), 0);
          mean[i] += simplex.weights[k] * vertex[i];
        }
      }
      EXPECT_NEAR(weights, 1, 1e-12);
      for (int i = 0; i <= dim; ++i) ASSERT_NEAR(mean[i], elevated[i], 1e-9);
    }
  }
}

TEST(EnclosingSimplexTest, SuccessiveVerticesAreNeighboursAlongAnAxis) {
  constexpr int kDim = 5;
  const SimplexLocator locator(kDim);
  for (int trial = 0; trial < 100; ++trial) {
    float feature[kDim];
    for (int i = 0; i < kDim; ++i) {
      feature[i] = static_cast<float>(RandomNormal(7, i, trial));
    }
    EnclosingSimplex simplex;
    locator.Locate(feature, &simplex);
    for (int k = 0; k <= kDim; ++k) {
      const auto vertex = Vertex(simplex, kDim, k);
      const auto next = Vertex(simplex, kDim, (k + 1) % (kDim + 1));
      int axes = 0;
      for (int i = 0; i <= kDim; ++i) {
        if (next[i] - vertex[i] == -kDim) {
          ++axes;
        } else {
          EXPECT_EQ(next[i] - vertex[i], 1);
        }
      }
      EXPECT_EQ(axes, 1);
    }
  }
}

TEST(EnclosingSimplexTest, DistancesKeepTheirRatio) {
  for (const int dim : {1, 2, 5}) {
    const SimplexLocator locator(dim);
    std::vector<float> feature(dim);
    std::vector<double> elevated(dim + 1);
    double squared = 0;
    for (int i = 0; i < dim; ++i) {
      feature[i] = static_cast<float>(RandomNormal(9, dim, i));
      squared += double{feature[i]} * feature[i];
    }
    locator.Elevate(feature.data(), elevated.data());
    double image = 0;
    double sum = 0;
    for (const double coordinate : elevated) {
      image += coordinate * coordinate;
      sum += coordinate;
    }
    EXPECT_NEAR(sum, 0, 1e-9);
    EXPECT_NEAR(image / squared, 2.0 / 3.0 * (dim + 1) * (dim + 1), 1e-6);
  }
}

TEST(EnclosingSimplexTest, LatticePointsAndTiesHaveOneVertex) {
  constexpr int kDim = 4;
  const SimplexLocator locator(kDim);
  const float origin[kDim] = {};
  EnclosingSimplex simplex;
  locator.Locate(origin, &simplex);
  EXPECT_EQ(simplex.weights[0], 1);
  for (int k = 1; k <= kDim; ++k) EXPECT_EQ(simplex.weights[k], 0);
  EXPECT_EQ(Vertex(simplex, kDim, 0), std::vector<int32_t>(kDim + 1, 0));
}

}  // namespace
}  // namespace freegs::semantics
