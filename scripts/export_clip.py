#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Turns OpenAI's CLIP checkpoints into a model folder for freegs_pipeline.

  scripts/export_clip.py ViT-B-16.pt --merges bpe_simple_vocab_16e6.txt.gz \\
      --out FOLDER [--dense-size 448]
  scripts/export_clip.py --random ViT-B/16 --seed 1 --merges ... --out FOLDER

Reads OpenAI's TorchScript files. Needs Debian's python3-torch and nothing else.
`freegs_pipeline model` does the same with safetensors of Hugging Face and
OpenCLIP, without Python; its graphs (semantics/clip_export/clip_networks.h) are
these. What the files of the folder are: semantics/clip/model_folder.h.

OpenCV 4.6 loads few of the graphs that PyTorch writes. The networks here are
CLIP's, said in other words:
- a layer norm is an instance norm over the positions, without gain and offset;
  those are folded into the linear layer that follows, or are full matrices
  where the residual follows;
- linear layers are 1x1 convolutions, and query, key and value are apart;
- the attention's scale is folded into the query;
- shapes are literal numbers but for the batch, and constants have no batch.
"""
import argparse
import ctypes
import ctypes.util
import gzip
import hashlib
import json
import math
import shutil
import struct
import sys
import warnings
import zlib
from dataclasses import dataclass
from pathlib import Path

# Before PyTorch: it says what to do where there is none.
from clip_checkpoint import (CheckpointError, named_architecture,
                             random_checkpoint, read_checkpoint)
from small_clip.stem import make_stem

import torch
import torch.nn.functional as F
from torch import nn

MEAN = [0.48145466, 0.4578275, 0.40821073]
STD = [0.26862954, 0.26130258, 0.27577711]


def conv_of(weight, bias, norm=None):
    """The linear layer W x + b as a 1x1 convolution; `norm` is the (gain,
    offset) of the layer norm before it, folded in."""
    weight, bias = weight.double(), bias.double()
    if norm is not None:
        bias = bias + weight @ norm[1].double()
        weight = weight * norm[0].double()
    conv = nn.Conv2d(weight.shape[1], weight.shape[0], 1)
    conv.weight.data = weight[:, :, None, None].float().contiguous()
    conv.bias.data = bias.float()
    return conv


def scale_of(gain, offset):
    """x * gain + offset for each channel, as a convolution."""
    width = len(gain)
    conv = nn.Conv2d(width, width, 1, groups=width)
    conv.weight.data = gain.float().reshape(width, 1, 1, 1).clone()
    conv.bias.data = offset.float().clone()
    return conv


def stem_of(state, width):
    """The convolutions beside the patches' linear map that a network of
    train_small_clip.py has; None in OpenAI's."""
    prefix = "visual.stem."
    own = {name[len(prefix):]: value for name, value in state.items()
           if name.startswith(prefix)}
    if not own:
        return None
    stem = make_stem(width)
    stem.load_state_dict(own)
    return stem


def norm_of(state, name):
    return state[name + ".weight"], state[name + ".bias"]


def to_columns(x, width, count):
    """(B, n, C) as (B, C, n, 1), for convolutions."""
    return x.permute(0, 2, 1).reshape(-1, width, count, 1)


def to_rows(x, width, count):
    return x.reshape(-1, width, count).permute(0, 2, 1)


class Block(nn.Module):
    """A residual attention block on (B, n, C)."""

    def __init__(self, state, prefix, heads, activation, value_only=False):
        super().__init__()
        weights = state[prefix + "attn.in_proj_weight"].chunk(3)
        biases = state[prefix + "attn.in_proj_bias"].chunk(3)
        norm = norm_of(state, prefix + "ln_1")
        self.width = weights[0].shape[1]
        self.heads, self.activation = heads, activation
        self.head_dim = self.width // heads
        self.v = conv_of(weights[2], biases[2], norm)
        self.out = conv_of(state[prefix + "attn.out_proj.weight"],
                           state[prefix + "attn.out_proj.bias"])
        self.value_only = value_only
        if value_only:
            return
        scale = self.head_dim ** -0.5
        self.q = conv_of(weights[0] * scale, biases[0] * scale, norm)
        self.k = conv_of(weights[1], biases[1], norm)
        self.fc = conv_of(state[prefix + "mlp.c_fc.weight"],
                          state[prefix + "mlp.c_fc.bias"],
                          norm_of(state, prefix + "ln_2"))
        self.proj = conv_of(state[prefix + "mlp.c_proj.weight"],
                            state[prefix + "mlp.c_proj.bias"])

    def forward(self, x, mask=None):
        n, shape = x.shape[1], (-1, self.heads, self.head_dim, x.shape[1])
        y = to_columns(F.instance_norm(x), self.width, n)
        if self.value_only:
            return to_rows(self.out(self.v(y)), self.width, n)
        q = self.q(y).reshape(shape).permute(0, 1, 3, 2)
        k = self.k(y).reshape(shape)
        v = self.v(y).reshape(shape).permute(0, 1, 3, 2)
        scores = q @ k
        if mask is not None:
            scores = scores + mask
        y = (F.softmax(scores, -1) @ v).permute(0, 1, 3, 2)
        y = self.out(y.reshape(-1, self.width, n, 1))
        x = x + to_rows(y, self.width, n)
        y = self.fc(to_columns(F.instance_norm(x), self.width, n))
        y = F.gelu(y) if self.activation == "gelu" else (
            y * torch.sigmoid(1.702 * y))
        return x + to_rows(self.proj(y), self.width, n)


def resized_positions(positions, grid):
    """Position vectors of a grid x grid image, bicubic."""
    old = round((positions.shape[0] - 1) ** 0.5)
    if old == grid:
        return positions
    cells = positions[1:].reshape(1, old, old, -1).permute(0, 3, 1, 2)
    cells = F.interpolate(cells, size=(grid, grid), mode="bicubic",
                          align_corners=False)
    return torch.cat([positions[:1],
                      cells.permute(0, 2, 3, 1).reshape(grid * grid, -1)])


class Visual(nn.Module):
    """Image -> 1 x D, or dense: 1 x D x grid x grid, the last block by its
    value projection only, without residual (MaskCLIP as FeatUp and F3RM
    take it)."""

    def __init__(self, state, arch, image_size, dense):
        super().__init__()
        self.dense, self.width = dense, arch.width
        self.dim, self.grid = arch.embedding_dim, image_size // arch.patch
        self.count = self.grid ** 2 + 1
        self.conv = nn.Conv2d(3, arch.width, arch.patch, arch.patch,
                              bias=False)
        self.conv.weight.data = state["visual.conv1.weight"]
        table = resized_positions(state["visual.positional_embedding"],
                                  self.grid).clone()
        table[0] += state["visual.class_embedding"]
        self.table = nn.Parameter(table)
        self.stem = stem_of(state, self.width)
        self.norm = scale_of(*norm_of(state, "visual.ln_pre"))
        prefix = "visual.transformer.resblocks."
        self.blocks = nn.ModuleList(
            Block(state, f"{prefix}{i}.", arch.heads, arch.activation,
                  value_only=dense and i == arch.layers - 1)
            for i in range(arch.layers))
        projection = state["visual.proj"].t()
        self.proj = conv_of(projection, torch.zeros(self.dim),
                            norm_of(state, "visual.ln_post"))

    def forward(self, image):
        x = self.conv(image)
        if self.stem is not None:
            x = x + self.stem(image)
        x = x.reshape(-1, self.width, self.count - 1)
        # The class token's place: OpenCV has no constants with a batch.
        x = torch.cat([x[:, :, 0:1] * 0.0, x], 2).permute(0, 2, 1) + self.table
        x = self.norm(to_columns(F.instance_norm(x), self.width, self.count))
        x = to_rows(x, self.width, self.count)
        for block in self.blocks:
            x = block(x)
        x = x[:, 1:] if self.dense else x[:, 0:1]
        count = self.count - 1 if self.dense else 1
        x = self.proj(to_columns(F.instance_norm(x), self.width, count))
        if self.dense:
            return x.reshape(-1, self.dim, self.grid, self.grid)
        return x.reshape(-1, self.dim)


class Text(nn.Module):
    """Token vectors -> the text's vector as it would be if it ended at each
    position."""

    def __init__(self, state, arch):
        super().__init__()
        self.width, self.count = arch.text_width, arch.context_length
        self.dim = arch.embedding_dim
        self.table = nn.Parameter(state["positional_embedding"])
        mask = torch.full((self.count, self.count), -math.inf).triu_(1)
        self.mask = nn.Parameter(mask, requires_grad=False)
        self.blocks = nn.ModuleList(
            Block(state, f"transformer.resblocks.{i}.", arch.text_heads,
                  arch.activation) for i in range(arch.text_layers))
        self.proj = conv_of(state["text_projection"].t(),
                            torch.zeros(self.dim), norm_of(state, "ln_final"))

    def forward(self, x):
        x = x + self.table
        for block in self.blocks:
            x = block(x, self.mask)
        x = self.proj(to_columns(F.instance_norm(x), self.width, self.count))
        return to_rows(x, self.dim, self.count)


def make_distinct(module):
    """The exporter shares parameters of equal value, which OpenCV cannot
    load: changes one number of each copy by what does not matter."""
    seen = set()
    for parameter in module.parameters():
        values = parameter.data
        key = (tuple(values.shape), values.numpy().tobytes())
        step = 1e-12
        while key in seen:
            values.view(-1)[0] += step
            step *= 2
            key = (tuple(values.shape), values.numpy().tobytes())
        seen.add(key)


def export_network(module, example, path):
    module.eval()
    make_distinct(module)
    with warnings.catch_warnings():
        # Of literal shapes, which are meant, and of instance norms, which have
        # no running statistics to freeze.
        warnings.simplefilter("ignore")
        torch.onnx.export(module, example, str(path), opset_version=13,
                          input_names=["input"], output_names=["output"],
                          do_constant_folding=True)


def write_token_table(table, path, half):
    rows, columns = table.shape
    values = table.half() if half else table.float()
    with open(path, "wb") as file:
        file.write(b"FREEGSTT" + struct.pack("<IIII", 1, int(half), rows,
                                             columns))
        file.write(values.contiguous().numpy().tobytes())


class Xxh128(ctypes.Structure):
    _fields_ = [("low", ctypes.c_uint64), ("high", ctypes.c_uint64)]


def hash_file(path):
    """XXH3, 128 bits, as HashFile() of core/io/files.h."""
    name = ctypes.util.find_library("xxhash")
    if name is None:
        raise CheckpointError("the xxHash library is missing: "
                              "apt-get install libxxhash0")
    function = ctypes.CDLL(name).XXH3_128bits
    function.restype = Xxh128
    function.argtypes = [ctypes.c_char_p, ctypes.c_size_t]
    data = path.read_bytes()
    digest = function(data, len(data))
    return f"{digest.high:016x}{digest.low:016x}"


def count_merges(path):
    data = path.read_bytes()
    try:
        text = gzip.decompress(data) if data[:2] == b"\x1f\x8b" else data
        lines = [line for line in text.decode().split("\n")[1:] if line]
    except (EOFError, OSError, ValueError, zlib.error) as error:
        raise CheckpointError(f"{path}: damaged: {error}") from error
    return min(len(lines), 49152 - 256 - 2)


@dataclass
class ModelCard:
    """What model.json says of a model besides its networks. The vocabulary is
    a list of groups of words to name things by, canonical one of phrases that
    say nothing in particular; min_word_confidence says how relevant the word
    of the last group must be (docs/clip.md)."""
    name: str
    licence: str
    origin: str
    vocabulary: list | None = None
    canonical: list | None = None
    min_word_confidence: float | None = None


def export_folder(state, arch, merges, out, card, dense_sizes=(),
                  half_table=True):
    """Writes the model folder `out`, made anew, from a checkpoint."""
    # A link is followed: what it leads to is made anew.
    merges, out = Path(merges), Path(out).resolve()
    if not merges.is_file():
        raise CheckpointError(f"{merges}: no such file; it comes with OpenAI's "
                              "code as bpe_simple_vocab_16e6.txt.gz")
    vocab_size = 512 + count_merges(merges) + 2
    if vocab_size != arch.vocab_size:
        raise CheckpointError(
            f"{merges}: makes {vocab_size} tokens, but the checkpoint has "
            f"{arch.vocab_size}; give the merges that belong to it")
    for size in dense_sizes:
        if size % arch.patch != 0:
            raise CheckpointError(f"dense size {size} is not a multiple of "
                                  f"the patch size {arch.patch}")
    if out.exists() and not is_model_folder(out) and (
            not out.is_dir() or any(out.iterdir())):
        raise CheckpointError(f"{out}: exists and is not a model folder; "
                              "name another")
    temporary = out.with_name(out.name + ".part")
    if temporary.exists():
        if not is_leftover(temporary):
            raise CheckpointError(f"{temporary}: is in the way of a temporary "
                                  "folder; move it")
        shutil.rmtree(temporary)
    temporary.mkdir(parents=True)
    try:
        fill_folder(state, arch, merges, temporary, card, dense_sizes,
                    half_table)
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        raise
    if out.exists():
        shutil.rmtree(out)
    temporary.rename(out)


def is_model_folder(folder):
    """Other programs write files of the name model.json, too."""
    try:
        info = json.loads((folder / "model.json").read_text())
    except (OSError, ValueError):
        return False
    return isinstance(info, dict) and info.get("format") == "FreeGS CLIP"


def is_leftover(folder):
    """Whether all in a folder are files that an export that was stopped
    leaves."""
    names = ("text_embedding", "vocab", "model.json")

    def is_ours(path):
        name = path.name.removesuffix(".part")
        return path.is_file() and (name.endswith(".onnx") or name in names)

    return folder.is_dir() and all(map(is_ours, folder.iterdir()))


def fill_folder(state, arch, merges, temporary, card, dense_sizes, half_table):
    """Writes the files of export_folder into an empty folder."""
    size = arch.image_size
    export_network(Visual(state, arch, size, dense=False),
                   torch.zeros(1, 3, size, size), temporary / "visual.onnx")
    dense = []
    for size in [arch.image_size, *dense_sizes]:
        file = "dense.onnx" if not dense else f"dense{size}.onnx"
        export_network(Visual(state, arch, size, dense=True),
                       torch.zeros(1, 3, size, size), temporary / file)
        dense.append({"file": file, "image_size": size,
                      "grid": size // arch.patch})
    export_network(Text(state, arch),
                   torch.zeros(1, arch.context_length, arch.text_width),
                   temporary / "text.onnx")
    write_token_table(state["token_embedding.weight"],
                      temporary / "text_embedding", half_table)
    shutil.copyfile(merges, temporary / "vocab")
    files = {path.name: {"bytes": path.stat().st_size, "hash": hash_file(path)}
             for path in sorted(temporary.iterdir())}
    info = {"format": "FreeGS CLIP", "version": 1, "name": card.name,
            "licence": card.licence, "origin": card.origin,
            "embedding_dim": arch.embedding_dim,
            "image_size": arch.image_size,
            "mean": MEAN, "std": STD, "dense": dense,
            "context_length": arch.context_length,
            "text_width": arch.text_width, "vocab_size": arch.vocab_size,
            "files": files}
    if card.vocabulary:
        info["vocabulary"] = card.vocabulary
    if card.canonical:
        info["canonical"] = card.canonical
    if card.min_word_confidence is not None:
        info["min_word_confidence"] = card.min_word_confidence
    (temporary / "model.json").write_text(json.dumps(info, indent=2) + "\n")


def add_source_options(parser):
    """The options that say which checkpoint; see source_checkpoint."""
    parser.add_argument("checkpoint", nargs="?",
                        help="OpenAI's .pt")
    parser.add_argument("--merges", type=Path,
                        help="byte-pair merges, plain or .gz")
    parser.add_argument("--random", metavar="NAME",
                        help="instead of a checkpoint, random numbers in the "
                        "architecture of ViT-B/16, ViT-B/32 or ViT-L/14")
    parser.add_argument("--seed", type=int, default=0)
    for size in ("image_size", "patch", "width", "layers", "heads",
                 "embedding_dim", "text_width", "text_layers", "text_heads"):
        parser.add_argument("--" + size.replace("_", "-"), type=int,
                            help="with --random, instead of NAME's")


def source_checkpoint(arguments):
    """(state, Architecture, merges file) that the options name."""
    if (arguments.checkpoint is None) == (arguments.random is None):
        raise CheckpointError("give either a checkpoint or --random NAME")
    merges = arguments.merges
    if merges is None:
        raise CheckpointError("give the byte-pair merges: --merges FILE")
    if arguments.random is None:
        return *read_checkpoint(arguments.checkpoint), merges
    arch = named_architecture(arguments.random, 512 + count_merges(merges) + 2)
    for name in vars(arch):
        if getattr(arguments, name, None) is not None:
            setattr(arch, name, getattr(arguments, name))
    state = random_checkpoint(arch, arguments.seed)
    return state, arch, merges


def main():
    parser = argparse.ArgumentParser(
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    add_source_options(parser)
    parser.add_argument("--out", required=True, type=Path)
    parser.add_argument("--dense-size", type=int, action="append", default=[],
                        help="another image size for dense features, such as "
                        "448; may be repeated")
    parser.add_argument("--name", help="what the model is called")
    parser.add_argument("--licence", help="of the weights")
    parser.add_argument("--origin", help="where the weights came from")
    parser.add_argument("--float-table", action="store_true",
                        help="token vectors with 32 bits instead of 16")
    arguments = parser.parse_args()
    try:
        state, arch, merges = source_checkpoint(arguments)
        random = arguments.random is not None
        origin = arguments.origin
        if origin is None and random:
            origin = f"random numbers, seed {arguments.seed}"
        elif origin is None:
            file = Path(arguments.checkpoint)
            digest = hashlib.sha256(file.read_bytes()).hexdigest()
            origin = f"{file.name}, SHA-256 {digest}"
        name = arguments.name or arguments.random or (
            f"CLIP ViT {arch.width}x{arch.layers} patch {arch.patch}")
        licence = arguments.licence or (
            "none: random numbers" if random
            else "that of the checkpoint; OpenAI's weights are MIT")
        export_folder(state, arch, merges, arguments.out,
                      ModelCard(name, licence, origin), arguments.dense_size,
                      half_table=not arguments.float_table)
    except (CheckpointError, OSError) as error:
        print(f"export_clip.py: {error}", file=sys.stderr)
        return 3
    print(f"{arguments.out}: {name}, {arch.embedding_dim} dimensions")
    return 0


if __name__ == "__main__":
    sys.exit(main())
