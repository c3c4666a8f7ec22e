// SPDX-License-Identifier: BSD-3-Clause
// Finds the simplex of the permutohedral lattice that contains a point.

#ifndef FREEGS_SEMANTICS_CRF_ENCLOSING_SIMPLEX_H_
#define FREEGS_SEMANTICS_CRF_ENCLOSING_SIMPLEX_H_

#include <array>
#include <cstdint>

namespace freegs::semantics {

// The permutohedral lattice of dimension d (Adams, Baek and Davis, "Fast
// High-Dimensional Filtering Using the Permutohedral Lattice", 2010) lies in
// the hyperplane of R^(d+1) in which the coordinates sum to zero. Its vertices
// are the integer points whose coordinates are all congruent modulo d + 1. The
// common remainder is a number 0 .. d, and every simplex has one vertex of each
// remainder.
inline constexpr int kMaxLatticeDim = 16;

struct EnclosingSimplex {
  // The vertex of remainder 0. For each coordinate, `rank` is its place when
  // coordinates are sorted by how far the point is beyond that vertex, the
  // farthest first.
  std::array<int32_t, kMaxLatticeDim + 1> origin = {};
  std::array<int32_t, kMaxLatticeDim + 1> rank = {};
  // Barycentric coordinates of the point by remainder. They are not negative
  // and sum to one.
  std::array<double, kMaxLatticeDim + 1> weights = {};

  // Writes the first d coordinates of the vertex with this remainder, 0 .. d.
  // They determine the last coordinate.
  void VertexKey(int dim, int remainder, int32_t* key) const {
    for (int i = 0; i < dim; ++i) {
      key[i] =
          origin[i] + remainder - (rank[i] > dim - remainder ? dim + 1 : 0);
    }
  }
};

// Maps features into the hyperplane of the lattice. The scale is such that
// splatting, blurring with [1 2 1] / 4 along every lattice direction, and
// slicing together are a Gaussian of standard deviation one in the features
// (section on filtering of the paper).
class SimplexLocator {
 public:
  // dim: 1 .. kMaxLatticeDim.
  explicit SimplexLocator(int dim);

  // Writes the image of a feature vector of dim numbers: dim + 1 coordinates
  // that sum to zero.
  void Elevate(const float* feature, double* elevated) const;

  // Finds the simplex around a feature vector. Its values are finite and at
  // most kMaxLatticeFeature in magnitude.
  void Locate(const float* feature, EnclosingSimplex* simplex) const;

 private:
  int dim_;
  std::array<double, kMaxLatticeDim> scale_;
};

// Larger features, in standard deviations, could overflow the integer
// coordinates.
inline constexpr float kMaxLatticeFeature = 1e6f;

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CRF_ENCLOSING_SIMPLEX_H_
