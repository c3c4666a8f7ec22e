// SPDX-License-Identifier: BSD-3-Clause
// The networks of a model folder (semantics/clip/model_folder.h) from the
// weights of a CLIP.
//
// OpenCV 4.6 loads few of the graphs that express a transformer in the obvious
// way. These are CLIP's networks, said in other words:
// - A layer norm is an instance norm over the positions, without gain and
//   offset. Those are folded into the linear layer that follows, or are a
//   convolution of their own where the residual follows.
// - Linear layers are 1 x 1 convolutions; query, key and value are apart.
// - The scale of the attention is folded into the query.
// - Shapes are literal numbers but for the batch, and constants have no batch.
// scripts/export_clip.py writes the same graphs.

#ifndef FREEGS_SEMANTICS_CLIP_EXPORT_CLIP_NETWORKS_H_
#define FREEGS_SEMANTICS_CLIP_EXPORT_CLIP_NETWORKS_H_

#include <vector>

#include "core/status.h"
#include "semantics/clip_export/clip_checkpoint.h"
#include "semantics/clip_export/onnx_graph.h"

namespace freegs::semantics {

// 1 x 3 x S x S image -> 1 x D; or, if dense, 1 x D x G x G: the last block by
// its value projection only, without its residual and its MLP (MaskCLIP).
// image_size S is a multiple of the patch. Errors as ClipCheckpoint; also
// kMissingDependency for more positions than an ONNX file can hold.
StatusOr<OnnxGraph> ImageNetwork(const ClipCheckpoint& checkpoint,
                                 int image_size,
                                 bool dense);

// 1 x C x W token vectors -> 1 x C x D: the vector of the text if it ended
// there.
StatusOr<OnnxGraph> TextNetwork(const ClipCheckpoint& checkpoint);

// The vectors of the positions of an image, (grid^2 + 1) x width with the class
// token first, for another grid: bicubic (Keys 1981, a = -0.75) between the
// centres of the cells, without smoothing, the outermost cells going on beyond
// the border. This is what PyTorch's interpolation does.
std::vector<float> ResizePositions(const std::vector<float>& positions,
                                   int width,
                                   int old_grid,
                                   int new_grid);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_EXPORT_CLIP_NETWORKS_H_
