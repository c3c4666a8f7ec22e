// SPDX-License-Identifier: BSD-3-Clause
// The simplex of the permutohedral lattice around a point.

#ifndef FREEGS_SEMANTICS_CRF_ENCLOSING_SIMPLEX_H_
#define FREEGS_SEMANTICS_CRF_ENCLOSING_SIMPLEX_H_

#include <array>
#include <cstdint>

namespace freegs::semantics {

// The permutohedral lattice of dimension d (Adams, Baek and Davis, "Fast
// High-Dimensional Filtering Using the Permutohedral Lattice", 2010) lies in
// the hyperplane of R^(d+1) where coordinates sum to zero: integer points whose
// coordinates are all congruent modulo d + 1. That remainder, 0 .. d, is the
// vertex's colour; every simplex has one vertex of each.
constexpr int kMaxLatticeDim = 16;

struct EnclosingSimplex {
  // The vertex of remainder 0, and for each coordinate its place when sorted by
  // how far the point is beyond that vertex, farthest first.
  std::array<int32_t, kMaxLatticeDim + 1> origin = {};
  std::array<int32_t, kMaxLatticeDim + 1> rank = {};
  // Barycentric coordinates by remainder: not negative, sum to one.
  std::array<double, kMaxLatticeDim + 1> weights = {};

  // The first d coordinates of the vertex with a remainder in 0 .. d; they
  // determine the last.
  void VertexKey(int dim, int remainder, int32_t* key) const {
    for (int i = 0; i < dim; ++i) {
      key[i] =
          origin[i] + remainder - (rank[i] > dim - remainder ? dim + 1 : 0);
    }
  }
};

// Maps features into the lattice's hyperplane, scaled so that splatting,
// blurring with [1 2 1] / 4 along every lattice direction and slicing are
// together a Gaussian of standard deviation one in features (their section on
// filtering with the lattice).
class SimplexLocator {
 public:
  // dim in 1 .. kMaxLatticeDim.
  explicit SimplexLocator(int dim);

  // The image of a feature vector of `dim` values: dim + 1 coordinates that sum
  // to zero.
  void Elevate(const float* feature, double* elevated) const;

  // The simplex around a feature vector. Finite values of at most
  // kMaxLatticeFeature.
  void Locate(const float* feature, EnclosingSimplex* simplex) const;

 private:
  int dim_;
  std::array<double, kMaxLatticeDim> scale_;
};

// Larger features, in standard deviations, could overflow integer coordinates.
constexpr float kMaxLatticeFeature = 1e6f;

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CRF_ENCLOSING_SIMPLEX_H_
