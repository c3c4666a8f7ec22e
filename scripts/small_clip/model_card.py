# SPDX-License-Identifier: BSD-3-Clause
"""The README.md of the model folder."""
from . import vocabulary
from .solids import SHAPES
from .vocabulary import COLOUR_NAMES, MATERIALS, shape_name


def model_card(state, measured, folder):
    """The text of the model folder's README.md."""
    arch, arguments = state.arch, state.arguments
    count = sum(p.numel() for p in state.model.parameters())
    megabytes = sum(p.stat().st_size for p in folder.iterdir()) / 1e6
    rows = "\n".join(
        f"| {name} | {100 * m['accuracy']:.1f} % | {m['images']} | "
        f"{', '.join(m['worst'])} |" for name, m in measured.items())
    return f"""# small_clip

A very small CLIP for machines without the official weights: two transformers
that put pictures and words into one space of {arch.embedding_dim} dimensions.
It knows drawn things and few words. For photographs of the world use
the official weights (`freegs_pipeline model`, docs/clip.md).

- Architecture: CLIP's ViT/{arch.patch}, width {arch.width}, {arch.layers} layers, and small convolutions
  beside its linear map of patches (scripts/small_clip/stem.py); text width {arch.text_width}, {arch.text_layers} layers, {arch.context_length} positions; {count} parameters, {megabytes:.1f} MB in all files.
- Training: {state.images_seen} images in {state.step} steps, {state.seconds / 3600:.1f} h, seed
  {arguments.seed}, only procedural drawings by `scripts/small_clip/`; no photographs, no
  other model's outputs. `scripts/train_small_clip.py`; in which runs: docs/clip.md.
- Licence: BSD-3-Clause, as the program.

## Vocabulary

- colours: {', '.join(COLOUR_NAMES)}
- materials: {', '.join(MATERIALS)}
- things: {', '.join(shape_name(i) for i in range(len(SHAPES)))}
- and their synonyms: {', '.join(sorted({w for k in vocabulary.WORDS for w in vocabulary.WORDS[k]}))};
  object, thing, stuff, texture, background, wall, floor

Words outside this list mean nothing to it. The things, and the styles in which
they are drawn, were chosen with the project's two rendered test scenes in view;
their images were not used.

## Measured

Zero-shot, on drawings with other views, backgrounds and random numbers than
training had (224 pixels; a fifth of the things partly hidden, a third blurred):

| question | top-1 | drawings | recognised least |
|---|---|---|---|
{rows}

Renderings with true masks, and pictures of where it goes wrong: docs/clip.md.

## Where it fails

- What is recognised least, above.
- Anything outside the vocabulary: it has no idea of what it does not know, and
  answers all the same.
- Photographs of the world, counting, and relations ("left of"): it has never
  seen any.
"""
