// SPDX-License-Identifier: BSD-3-Clause
// What the tensors of a CLIP are called in the files of others.

#ifndef FREEGS_SEMANTICS_CLIP_EXPORT_CLIP_LAYOUT_H_
#define FREEGS_SEMANTICS_CLIP_EXPORT_CLIP_LAYOUT_H_

#include <set>
#include <string>
#include <vector>

namespace freegs::semantics {

// Names of tensors; those of norms and linear layers without ".weight" and
// ".bias". Arrays of two hold those of the image network, then of the text
// network; `norms` and `linears` are in the order of ClipCheckpoint::BlockNorm
// and BlockLinear.
struct ClipLayout {
  const char* patches;
  const char* class_token;
  const char* image_positions;
  const char* text_positions;
  const char* tokens;
  const char* first_norm;
  const char* last_norms[2];
  const char* projections[2];  // With everything that belongs to the name.
  const char* blocks[2];       // Before the number of the layer.
  bool projections_have_rows;  // D x width, else width x D.
  const char* norms[2];        // Within a block, as the following.
  const char* linears[6];      // Empty: in joint_qkv.
  const char* joint_qkv;       // Query, key, value above one another, or null.
  // Tensors of no use here: what training needs, and numbers that shapes tell.
  std::vector<const char*> unused;

  // What the names of a block's tensors begin with.
  std::string BlockName(int tower, int layer) const;
};

// The names in files of Hugging Face's transformers, and in those of OpenCLIP.
// The layouts are constants that live as long as the program.
const ClipLayout& HuggingFaceLayout();
const ClipLayout& OpenClipLayout();

// All tensors that a CLIP of so many layers has.
std::set<std::string> TensorNames(const ClipLayout& layout,
                                  int visual_layers,
                                  int text_layers);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_EXPORT_CLIP_LAYOUT_H_
