// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip_export/clip_layout.h"

namespace freegs::semantics {

std::string ClipLayout::BlockName(int tower, int layer) const {
  return blocks[tower] + std::to_string(layer) + ".";
}

const ClipLayout& HuggingFaceLayout() {
  static const ClipLayout layout = {
      .patches = "vision_model.embeddings.patch_embedding.weight",
      .class_token = "vision_model.embeddings.class_embedding",
      .image_positions = "vision_model.embeddings.position_embedding.weight",
      .text_positions = "text_model.embeddings.position_embedding.weight",
      .tokens = "text_model.embeddings.token_embedding.weight",
      .first_norm = "vision_model.pre_layrnorm",  // Their spelling.
      .last_norms = {"vision_model.post_layernorm",
                     "text_model.final_layer_norm"},
      .projections = {"visual_projection.weight", "text_projection.weight"},
      .blocks = {"vision_model.encoder.layers.", "text_model.encoder.layers."},
      .projections_have_rows = true,
      .norms = {"layer_norm1", "layer_norm2"},
      .linears = {"self_attn.q_proj",
                  "self_attn.k_proj",
                  "self_attn.v_proj",
                  "self_attn.out_proj",
                  "mlp.fc1",
                  "mlp.fc2"},
      .joint_qkv = nullptr,
      .unused = {"logit_scale",
                 "vision_model.embeddings.position_ids",
                 "text_model.embeddings.position_ids"}};
  return layout;
}

const ClipLayout& OpenClipLayout() {
  static const ClipLayout layout = {
      .patches = "visual.conv1.weight",
      .class_token = "visual.class_embedding",
      .image_positions = "visual.positional_embedding",
      .text_positions = "positional_embedding",
      .tokens = "token_embedding.weight",
      .first_norm = "visual.ln_pre",
      .last_norms = {"visual.ln_post", "ln_final"},
      .projections = {"visual.proj", "text_projection"},
      .blocks = {"visual.transformer.resblocks.", "transformer.resblocks."},
      .projections_have_rows = false,
      .norms = {"ln_1", "ln_2"},
      .linears = {"", "", "", "attn.out_proj", "mlp.c_fc", "mlp.c_proj"},
      .joint_qkv = "attn.in_proj_",
      .unused = {"logit_scale",
                 "attn_mask",
                 "input_resolution",
                 "context_length",
                 "vocab_size"}};
  return layout;
}

std::set<std::string> TensorNames(const ClipLayout& layout,
                                  int visual_layers,
                                  int text_layers) {
  std::set<std::string> names = {layout.patches,
                                 layout.class_token,
                                 layout.image_positions,
                                 layout.text_positions,
                                 layout.tokens,
                                 layout.projections[0],
                                 layout.projections[1]};
  const auto add = [&names](const std::string& name) {
    names.insert(name + ".weight");
    names.insert(name + ".bias");
  };
  add(layout.first_norm);
  const int layers[] = {visual_layers, text_layers};
  for (int tower = 0; tower < 2; ++tower) {
    add(layout.last_norms[tower]);
    for (int i = 0; i < layers[tower]; ++i) {
      const std::string block = layout.BlockName(tower, i);
      for (const char* norm : layout.norms) add(block + norm);
      for (const char* linear : layout.linears) {
        if (*linear != '\0') add(block + linear);
      }
      if (layout.joint_qkv != nullptr) {
        names.insert(block + layout.joint_qkv + "weight");
        names.insert(block + layout.joint_qkv + "bias");
      }
    }
  }
  return names;
}

}  // namespace freegs::semantics
