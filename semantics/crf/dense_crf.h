// SPDX-License-Identifier: BSD-3-Clause
// A conditional random field in which all pixels of an image are neighbours
// (Kraehenbuehl and Koltun, "Efficient Inference in Fully Connected CRFs with
// Gaussian Edge Potentials", 2011). FreeGS refines the borders of its instance
// masks with it.

#ifndef FREEGS_SEMANTICS_CRF_DENSE_CRF_H_
#define FREEGS_SEMANTICS_CRF_DENSE_CRF_H_

#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/crf/permutohedral_lattice.h"

namespace freegs::semantics {

// Distances are relative to the square root of the number of pixels, so that
// the same picture gets about the same labels at any resolution. Defaults but
// for appearance_color_sigma are what FreeGS uses, as seen at its resolution.
struct DenseCrfOptions {
  // Appearance kernel: pixels that are near and of like colour (RGB, channels
  // in [0, 1]) tend to have the same label. FreeGS: 3 / 255 in colour, less
  // than the noise of most photographs.
  double appearance_weight = 4;
  double appearance_position_sigma = 0.15;
  double appearance_color_sigma = 0.04;

  // Smoothness kernel: neighbours tend to have the same label.
  double smoothness_weight = 3;
  double smoothness_position_sigma = 0.0025;

  // Mean field updates; the paper finds ten enough.
  int iterations = 10;

  Status Check() const;
};

struct DenseCrfResult {
  ImageF probabilities;  // W x H x L, each pixel's sum to one.
  ImageU16 labels;       // W x H, the most probable; the lowest of equals.
};

// The kernels of one image: built once, used for any unary energies.
class DenseCrf {
 public:
  // image: RGB in [0, 1], W x H x 3. kInvalidArgument for options out of range,
  // an image that is empty or has other than 3 channels, colours that are not
  // finite or beyond 1e6 sigmas, and images too large for a lattice of five
  // dimensions (about 3.5e8 pixels). Memory: see PermutohedralLattice, with
  // dimensions 5 and 2.
  static StatusOr<DenseCrf> Build(const ImageF& image,
                                  const DenseCrfOptions& options,
                                  ThreadPool& pool);

  // Minimises the energy
  //   E(x) = sum_i unary_i(x_i) + sum_{i < j} [x_i != x_j] k(i, j),
  //   k(i, j) = sum of the two kernels' weight exp(-|f_i - f_j|^2 / 2)
  //             / sqrt(D_i D_j)
  // approximately, by mean field updates of all pixels at once (algorithm 1 of
  // the paper). D_i is the sum of a Gaussian over all pixels: weights mean the
  // same whatever the sigmas, and pixels unlike all others still count.
  //
  // unary: energies, W x H x L, such as -log of probabilities; infinity forbids
  // a label. Probabilities are never NaN, and the same for any number of
  // threads.
  // kInvalidArgument when the size is not the image's, L exceeds 65535, W H L
  // exceeds 2^31, an energy is NaN or minus infinity, or a pixel has no label
  // that is allowed. Memory: 4 W H L bytes beside the result and what filtering
  // takes.
  StatusOr<DenseCrfResult> Infer(const ImageF& unary, ThreadPool& pool) const;

 private:
  struct Kernel {
    PermutohedralLattice lattice;
    float weight;
  };

  DenseCrf() = default;

  Status AddKernel(const std::vector<float>& features,
                   int dim,
                   double weight,
                   ThreadPool& pool);
  Status CheckUnary(const ImageF& unary, ThreadPool& pool) const;

  int width_ = 0;
  int height_ = 0;
  int iterations_ = 0;
  std::vector<Kernel> kernels_;
  // Of each pixel, what all kernels' messages contain of its own label.
  std::vector<float> self_weights_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CRF_DENSE_CRF_H_
