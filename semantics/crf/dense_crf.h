// SPDX-License-Identifier: BSD-3-Clause
// A conditional random field in which all pixels of an image are neighbours
// (Kraehenbuehl and Koltun, "Efficient Inference in Fully Connected CRFs with
// Gaussian Edge Potentials", 2011). It moves the borders of masks to the edges
// of the image, as FreeGS does with its instance masks.
//
//   FREEGS_ASSIGN_OR_RETURN(const ImageF unary,
//                           UnaryFromLabels(labels, num_labels, 0.7));
//   FREEGS_ASSIGN_OR_RETURN(const DenseCrf crf,
//                           DenseCrf::Build(image, DenseCrfOptions(), pool));
//   FREEGS_ASSIGN_OR_RETURN(const DenseCrfResult result,
//                           crf.Infer(unary, pool));

#ifndef FREEGS_SEMANTICS_CRF_DENSE_CRF_H_
#define FREEGS_SEMANTICS_CRF_DENSE_CRF_H_

#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/crf/permutohedral_lattice.h"

namespace freegs::semantics {

// Lengths are relative to the square root of the number of pixels, so that the
// same picture gets about the same labels at any resolution. Except for
// appearance_color_sigma, the defaults are those of FreeGS at its resolution.
struct DenseCrfOptions {
  // The appearance kernel: pixels that are near each other and have similar
  // colours (RGB in [0, 1]) tend to have the same label. FreeGS has 3 / 255 as
  // the standard deviation in colour, which is less than the noise of most
  // photographs.
  double appearance_weight = 4;
  double appearance_position_sigma = 0.15;
  double appearance_color_sigma = 0.04;

  // The smoothness kernel: neighbouring pixels tend to have the same label.
  double smoothness_weight = 3;
  double smoothness_position_sigma = 0.0025;

  // Number of mean field updates. The paper finds ten enough.
  int iterations = 10;

  Status Check() const;
};

struct DenseCrfResult {
  ImageF probabilities;  // W x H x L; they sum to one at each pixel.
  ImageU16 labels;  // W x H: the most probable label, the lowest of equals.
};

// The kernels of one image. They are built once and serve any number of unary
// energies.
class DenseCrf {
 public:
  // image: RGB in [0, 1], W x H x 3. Memory: see PermutohedralLattice, for one
  // lattice of 5 and one of 2 dimensions. kInvalidArgument for options out of
  // range, for an image that is empty or does not have 3 channels, for colours
  // that are not finite or exceed 1e6 standard deviations, and for more than
  // about 3.5e8 pixels.
  static StatusOr<DenseCrf> Build(const ImageF& image,
                                  const DenseCrfOptions& options,
                                  ThreadPool& pool);

  // Minimises the energy
  //   E(x) = sum_i unary_i(x_i) + sum_{i < j} [x_i != x_j] k(i, j),
  //   k(i, j) = sum of the two kernels' weight exp(-|f_i - f_j|^2 / 2)
  //             / sqrt(D_i D_j)
  // approximately, by mean field updates of all pixels at once (algorithm 1 of
  // the paper). D_i is the sum of the Gaussian over all pixels. Due to this
  // division a weight means the same at any standard deviation, and a pixel
  // that is unlike all others still counts.
  //
  // unary: energies, W x H x L, such as -log of probabilities; infinity forbids
  // a label. Probabilities are never NaN, and they have the same bytes for any
  // number of threads. Memory: 4 W H L bytes beside the result and the filter.
  //
  // kInvalidArgument if the size is not that of the image, L exceeds 65535, W H
  // L exceeds 2^31, an energy is NaN or minus infinity, or a pixel has no label
  // that is allowed.
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
  // For each pixel: what the messages of all kernels contain of its own label.
  std::vector<float> self_weights_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CRF_DENSE_CRF_H_
