# SPDX-License-Identifier: BSD-3-Clause
"""CLIP checkpoints as dictionaries of float32 tensors with the names of
OpenAI's release: read from its TorchScript files, or drawn at random. Only
vision transformers, no ResNets."""
import pickle
import sys
from dataclasses import dataclass
from pathlib import Path

try:
    import torch
except ImportError:
    print(f"PyTorch is missing for {sys.executable}: apt-get install "
          "python3-torch, and run with /usr/bin/python3", file=sys.stderr)
    raise SystemExit(5)


class CheckpointError(Exception):
    """Names the file, what is wrong with it, and what to do."""


@dataclass
class Architecture:
    image_size: int
    patch: int
    width: int
    layers: int
    heads: int
    embedding_dim: int
    text_width: int
    text_layers: int
    text_heads: int
    context_length: int
    vocab_size: int
    activation: str = "quick_gelu"

    @property
    def grid(self):
        return self.image_size // self.patch


def count_layers(state, prefix):
    return len({name[len(prefix):].split(".")[0]
                for name in state if name.startswith(prefix)})


def architecture_of(state):
    """Sizes from the tensors' shapes; what shapes do not tell is as OpenAI's
    models have it."""
    for name in ("visual.conv1.weight", "visual.proj", "text_projection",
                 "visual.transformer.resblocks.0.ln_1.weight"):
        if name not in state:
            raise CheckpointError(
                f"the checkpoint has no {name}: it is not a CLIP with a vision "
                "transformer; export a ViT, such as ViT-B/16")
    width, _, patch, _ = state["visual.conv1.weight"].shape
    tokens = state["visual.positional_embedding"].shape[0]
    grid = round((tokens - 1) ** 0.5)
    if grid * grid + 1 != tokens:
        raise CheckpointError(f"{tokens} image positions are not a square grid")
    text_width = state["text_projection"].shape[0]
    return Architecture(
        image_size=grid * patch,
        patch=patch,
        width=width,
        layers=count_layers(state, "visual.transformer.resblocks."),
        heads=max(1, width // 64),
        embedding_dim=state["visual.proj"].shape[1],
        text_width=text_width,
        text_layers=count_layers(state, "transformer.resblocks."),
        text_heads=max(1, text_width // 64),
        context_length=state["positional_embedding"].shape[0],
        vocab_size=state["token_embedding.weight"].shape[0])


def read_checkpoint(path):
    """(state, Architecture) of OpenAI's file, or of a pickled state."""
    path = Path(path)
    if path.is_dir() or path.suffix == ".safetensors":
        raise CheckpointError(
            f"{path}: this script reads OpenAI's .pt files; for safetensors "
            f"there is: freegs_pipeline model {path} --out FOLDER")
    if not path.is_file():
        raise CheckpointError(f"{path}: no such file")
    try:
        state = torch.jit.load(str(path), map_location="cpu").state_dict()
    except RuntimeError:
        try:
            state = torch.load(str(path), map_location="cpu")
            state = state.get("state_dict", state)
        except (AttributeError, EOFError, RuntimeError, ValueError,
                pickle.UnpicklingError) as error:
            raise CheckpointError(
                f"{path}: damaged, or no checkpoint: {error}") from error
    state = {name: tensor.detach().float() for name, tensor in state.items()}
    return state, architecture_of(state)


def random_checkpoint(arch, seed):
    """A checkpoint of the architecture with numbers of about the size that
    training gives them, so that every part of the networks matters."""
    generator = torch.Generator().manual_seed(seed)

    def draw(*shape, std=1.0, mean=0.0):
        return torch.randn(*shape, generator=generator) * std + mean

    state = {}

    def draw_norm(name, width):
        state[name + ".weight"] = draw(width, std=0.2, mean=1)
        state[name + ".bias"] = draw(width, std=0.1)

    def draw_blocks(prefix, width, layers):
        for i in range(layers):
            block = f"{prefix}.resblocks.{i}."
            draw_norm(block + "ln_1", width)
            draw_norm(block + "ln_2", width)
            for name, rows, columns in (("attn.out_proj.", width, width),
                                        ("mlp.c_fc.", 4 * width, width),
                                        ("mlp.c_proj.", width, 4 * width)):
                state[block + name + "weight"] = draw(
                    rows, columns, std=columns ** -0.5)
                state[block + name + "bias"] = draw(rows, std=0.1)
            state[block + "attn.in_proj_weight"] = draw(
                3 * width, width, std=1.5 * width ** -0.5)
            state[block + "attn.in_proj_bias"] = draw(3 * width, std=0.1)

    width, text_width = arch.width, arch.text_width
    state["visual.conv1.weight"] = draw(
        width, 3, arch.patch, arch.patch, std=(3 * arch.patch ** 2) ** -0.5)
    state["visual.class_embedding"] = draw(width, std=0.5)
    state["visual.positional_embedding"] = draw(
        arch.grid ** 2 + 1, width, std=0.5)
    draw_norm("visual.ln_pre", width)
    draw_blocks("visual.transformer", width, arch.layers)
    draw_norm("visual.ln_post", width)
    state["visual.proj"] = draw(width, arch.embedding_dim, std=width ** -0.5)
    state["token_embedding.weight"] = draw(
        arch.vocab_size, text_width, std=0.5)
    state["positional_embedding"] = draw(
        arch.context_length, text_width, std=0.2)
    draw_blocks("transformer", text_width, arch.text_layers)
    draw_norm("ln_final", text_width)
    state["text_projection"] = draw(
        text_width, arch.embedding_dim, std=text_width ** -0.5)
    return state


def named_architecture(name, vocab_size=49408):
    """The sizes of OpenAI's vision transformers."""
    sizes = {"ViT-B/32": (224, 32, 768, 12, 512, 512),
             "ViT-B/16": (224, 16, 768, 12, 512, 512),
             "ViT-L/14": (224, 14, 1024, 24, 768, 768)}
    if name not in sizes:
        raise CheckpointError(f"{name}: known are {', '.join(sizes)}")
    image_size, patch, width, layers, dim, text_width = sizes[name]
    return Architecture(image_size, patch, width, layers, width // 64, dim,
                        text_width, 12, text_width // 64, 77, vocab_size)
