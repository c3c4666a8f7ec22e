#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes what PyTorch makes of an image and some texts, for comparison with
the model folder that export_clip.py wrote from the same checkpoint.

  scripts/check_clip_export.py CHECKPOINT --merges FILE --model FOLDER
  FREEGS_CLIP_MODEL=FOLDER build/bin/semantics_test --gtest_filter='*OpenCvClip*'

Takes the checkpoint options of export_clip.py. Writes FOLDER/reference.json
and FOLDER/reference.png. The networks here are as CLIP's paper and OpenAI's
release have them, with none of the exporter's rewriting; resizing is PIL's.
Needs Debian's python3-torch and python3-pil; texts are ASCII only.
"""
import argparse
import gzip
import json
import math
import re
import sys
from pathlib import Path

from clip_checkpoint import CheckpointError
from export_clip import add_source_options, resized_positions, source_checkpoint

import torch
import torch.nn.functional as F
from PIL import Image, ImageDraw

TEXTS = ["red apple", "a photo of a red apple", "object", "",
         "Things, stuff & texture: 42!", "photo of red " * 40]


def norm(state, name, x):
    return F.layer_norm(x, x.shape[-1:], state[name + ".weight"],
                        state[name + ".bias"])


def attention(state, prefix, x, heads, mask):
    n, width = x.shape
    qkv = F.linear(x, state[prefix + "in_proj_weight"],
                   state[prefix + "in_proj_bias"])
    q, k, v = (part.reshape(n, heads, -1).transpose(0, 1)
               for part in qkv.chunk(3, dim=-1))
    scores = q @ k.transpose(1, 2) / math.sqrt(width / heads)
    if mask is not None:
        scores = scores + mask
    x = (scores.softmax(-1) @ v).transpose(0, 1).reshape(n, width)
    return F.linear(x, state[prefix + "out_proj.weight"],
                    state[prefix + "out_proj.bias"])


def block(state, prefix, x, heads, activation, mask=None):
    x = x + attention(state, prefix + "attn.", norm(state, prefix + "ln_1", x),
                      heads, mask)
    y = F.linear(norm(state, prefix + "ln_2", x),
                 state[prefix + "mlp.c_fc.weight"],
                 state[prefix + "mlp.c_fc.bias"])
    y = F.gelu(y) if activation == "gelu" else y * torch.sigmoid(1.702 * y)
    return x + F.linear(y, state[prefix + "mlp.c_proj.weight"],
                        state[prefix + "mlp.c_proj.bias"])


def last_values(state, prefix, x):
    """MaskCLIP: what every position would say to all others."""
    x = norm(state, prefix + "ln_1", x)
    x = F.linear(x, state[prefix + "attn.in_proj_weight"].chunk(3)[2],
                 state[prefix + "attn.in_proj_bias"].chunk(3)[2])
    return F.linear(x, state[prefix + "attn.out_proj.weight"],
                    state[prefix + "attn.out_proj.bias"])


def encode_image(state, arch, pixels, dense):
    x = F.conv2d(pixels[None], state["visual.conv1.weight"],
                 stride=arch.patch)
    grid = x.shape[-1]
    x = x.reshape(arch.width, grid * grid).t()
    x = torch.cat([state["visual.class_embedding"][None], x])
    x = x + resized_positions(state["visual.positional_embedding"], grid)
    x = norm(state, "visual.ln_pre", x)
    for i in range(arch.layers):
        prefix = f"visual.transformer.resblocks.{i}."
        if dense and i == arch.layers - 1:
            x = last_values(state, prefix, x)
        else:
            x = block(state, prefix, x, arch.heads, arch.activation)
    x = norm(state, "visual.ln_post", x) @ state["visual.proj"]
    return x[1:] if dense else x[0]


def encode_text(state, arch, ids):
    padded = ids + [0] * (arch.context_length - len(ids))
    x = state["token_embedding.weight"][padded] + state["positional_embedding"]
    mask = torch.full((len(padded), len(padded)), -math.inf).triu_(1)
    for i in range(arch.text_layers):
        x = block(state, f"transformer.resblocks.{i}.", x, arch.text_heads,
                  arch.activation, mask)
    return norm(state, "ln_final", x)[len(ids) - 1] @ state["text_projection"]


class Tokenizer:
    """Byte-pair encoding of ASCII text."""

    def __init__(self, path):
        data = Path(path).read_bytes()
        text = gzip.decompress(data) if data[:2] == b"\x1f\x8b" else data
        lines = text.decode().split("\n")[1:49152 - 256 - 2 + 1]
        merges = [tuple(line.split()) for line in lines if line]
        printable = [*range(33, 127), *range(161, 173), *range(174, 256)]
        pieces = [chr(c) for c in printable]
        pieces += [chr(256 + i) for i in range(256 - len(pieces))]
        pieces += [piece + "</w>" for piece in pieces]
        pieces += ["".join(pair) for pair in merges]
        self.ids = {piece: i for i, piece in enumerate(pieces)}
        self.ranks = {pair: i for i, pair in enumerate(merges)}
        self.start = len(pieces)

    def word(self, text):
        pieces = [*text[:-1], text[-1] + "</w>"]
        while len(pieces) > 1:
            ranked = [(self.ranks.get(pair, math.inf), i)
                      for i, pair in enumerate(zip(pieces, pieces[1:]))]
            rank, i = min(ranked)
            if rank == math.inf:
                break
            pieces[i:i + 2] = [pieces[i] + pieces[i + 1]]
        return [self.ids[piece] for piece in pieces]

    def __call__(self, text, length):
        words = re.findall(r"'s|'t|'re|'ve|'m|'ll|'d|[a-z]+|[0-9]|[^\sa-z0-9]+",
                           text.lower())
        ids = [self.start] + [i for word in words for i in self.word(word)]
        return ids[:length - 1] + [self.start + 1]


def draw_image():
    """Some colours, edges and fine structure, wider than high."""
    image = Image.new("RGB", (331, 217))
    image.putdata([(x * 255 // 331, y * 255 // 217, (7 * x + 13 * y) % 256)
                   for y in range(217) for x in range(331)])
    draw = ImageDraw.Draw(image)
    draw.ellipse((40, 30, 150, 140), fill=(200, 20, 30))
    draw.rectangle((180, 90, 300, 200), fill=(30, 90, 200))
    return image


def to_tensor(image, info):
    data = torch.frombuffer(bytearray(image.tobytes()), dtype=torch.uint8)
    pixels = data.reshape(image.height, image.width, 3).permute(2, 0, 1)
    mean, std = (torch.tensor(info[key])[:, None, None]
                 for key in ("mean", "std"))
    return (pixels.float() / 255 - mean) / std


def center_square(image, size):
    scale = size / min(image.size)
    width, height = (size if side == min(image.size) else int(scale * side)
                     for side in image.size)
    image = image.resize((width, height), Image.BICUBIC)
    x, y = round((width - size) / 2), round((height - size) / 2)
    return image.crop((x, y, x + size, y + size))


def numbers(tensor):
    return [float(f"{value:.6g}") for value in tensor.flatten().tolist()]


def main():
    parser = argparse.ArgumentParser(
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    add_source_options(parser)
    parser.add_argument("--model", required=True, type=Path)
    arguments = parser.parse_args()
    try:
        state, arch, merges = source_checkpoint(arguments)
        info = json.loads((arguments.model / "model.json").read_text())
        tokenizer = Tokenizer(merges)
    except (CheckpointError, OSError, ValueError) as error:
        print(f"check_clip_export.py: {error}", file=sys.stderr)
        return 3
    image = draw_image()
    image.save(arguments.model / "reference.png")
    with torch.no_grad():
        reference = {
            "image": numbers(encode_image(
                state, arch,
                to_tensor(center_square(image, info["image_size"]), info),
                dense=False)),
            "dense": [],
            "texts": []}
        for network in info["dense"]:
            size = network["image_size"]
            resized = image.resize((size, size), Image.BICUBIC)
            features = encode_image(state, arch, to_tensor(resized, info),
                                    dense=True)
            reference["dense"].append(
                {"image_size": size, "features": numbers(features)})
        for text in TEXTS:
            ids = tokenizer(text, arch.context_length)
            reference["texts"].append(
                {"text": text, "ids": ids,
                 "embedding": numbers(encode_text(state, arch, ids))})
    (arguments.model / "reference.json").write_text(json.dumps(reference))
    print(f"{arguments.model / 'reference.json'} written")
    return 0


if __name__ == "__main__":
    sys.exit(main())
