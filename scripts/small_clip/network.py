# SPDX-License-Identifier: BSD-3-Clause
"""CLIP's two encoders for training, with the names of OpenAI's release, and
the byte-pair merges of a small vocabulary."""
import math
import re
from collections import Counter

import numpy as np
import torch
import torch.nn.functional as F
from torch import nn

from clip_checkpoint import Architecture
from export_clip import MEAN, STD, resized_positions
from .stem import make_stem

CONTEXT = 32


def linear(x, weight, bias):
    """W x + b on (B, n, C) as a 1x1 convolution: with Debian's PyTorch up to
    1.7 times faster than F.linear, forward and backward."""
    x = F.conv2d(x.transpose(1, 2).unsqueeze(-1), weight[:, :, None, None],
                 bias)
    return x.squeeze(-1).transpose(1, 2)


def normalised(images):
    """uint8 (N, H, W, 3) as CLIP takes them."""
    x = torch.from_numpy(np.ascontiguousarray(images)).permute(0, 3, 1, 2)
    mean, std = (torch.tensor(v)[:, None, None] for v in (MEAN, STD))
    return (x.float() / 255 - mean) / std


class Attention(nn.Module):
    def __init__(self, width, heads):
        super().__init__()
        self.heads = heads
        self.in_proj_weight = nn.Parameter(
            torch.randn(3 * width, width) * width ** -0.5)
        self.in_proj_bias = nn.Parameter(torch.zeros(3 * width))
        self.out_proj = nn.Linear(width, width)

    def forward(self, x, mask):
        b, n, width = x.shape
        qkv = linear(x, self.in_proj_weight, self.in_proj_bias)
        q, k, v = qkv.reshape(b, n, 3, self.heads, -1).permute(2, 0, 3, 1, 4)
        scores = q @ k.transpose(-1, -2) * (width / self.heads) ** -0.5
        if mask is not None:
            scores = scores + mask[:n, :n]
        y = scores.softmax(-1) @ v
        y = y.transpose(1, 2).reshape(b, n, width)
        return linear(y, self.out_proj.weight, self.out_proj.bias)


    def value_only(self, x):
        value = len(self.in_proj_bias) // 3 * 2
        return linear(linear(x, self.in_proj_weight[value:],
                             self.in_proj_bias[value:]),
                      self.out_proj.weight, self.out_proj.bias)


class Mlp(nn.Module):
    def __init__(self, width):
        super().__init__()
        self.c_fc = nn.Linear(width, 4 * width)
        self.c_proj = nn.Linear(4 * width, width)

    def forward(self, x):
        x = linear(x, self.c_fc.weight, self.c_fc.bias)
        x = x * torch.sigmoid(1.702 * x)
        return linear(x, self.c_proj.weight, self.c_proj.bias)


class Block(nn.Module):
    def __init__(self, width, heads, depth):
        super().__init__()
        self.ln_1, self.ln_2 = nn.LayerNorm(width), nn.LayerNorm(width)
        self.attn, self.mlp = Attention(width, heads), Mlp(width)
        for layer in (self.attn.out_proj, self.mlp.c_proj):
            nn.init.normal_(layer.weight, std=(2 * depth * width) ** -0.5)
            nn.init.zeros_(layer.bias)
        nn.init.normal_(self.mlp.c_fc.weight, std=(2 * width) ** -0.5)

    def forward(self, x, mask=None):
        x = x + self.attn(self.ln_1(x), mask)
        return x + self.mlp(self.ln_2(x))


class Transformer(nn.Module):
    def __init__(self, width, layers, heads):
        super().__init__()
        self.resblocks = nn.ModuleList(
            Block(width, heads, layers) for _ in range(layers))

    def forward(self, x, mask=None):
        for block in self.resblocks:
            x = block(x, mask)
        return x


class Visual(nn.Module):
    def __init__(self, arch):
        super().__init__()
        width = arch.width
        self.patch = arch.patch
        self.conv1 = nn.Conv2d(3, width, arch.patch, arch.patch, bias=False)
        self.stem = make_stem(width)
        self.class_embedding = nn.Parameter(torch.randn(width) * 0.02)
        self.positional_embedding = nn.Parameter(
            torch.randn(arch.grid ** 2 + 1, width) * 0.02)
        self.ln_pre, self.ln_post = nn.LayerNorm(width), nn.LayerNorm(width)
        self.transformer = Transformer(width, arch.layers, arch.heads)
        self.proj = nn.Parameter(
            torch.randn(width, arch.embedding_dim) * width ** -0.5)

    def forward(self, images):
        """The vectors of images, and of their patches as MaskCLIP takes them:
        through the last block by its value projection only."""
        x = self.conv1(images) + self.stem(images)
        x = x.flatten(2).transpose(1, 2)
        first = self.class_embedding.expand(len(x), 1, -1)
        positions = resized_positions(self.positional_embedding,
                                      images.shape[-1] // self.patch)
        x = self.ln_pre(torch.cat([first, x], 1) + positions)
        *blocks, last = self.transformer.resblocks
        for block in blocks:
            x = block(x)
        patches = self.ln_post(last.attn.value_only(last.ln_1(x[:, 1:])))
        return self.ln_post(last(x)[:, 0]) @ self.proj, linear(
            patches, self.proj.t(), None)


class SmallClip(nn.Module):
    def __init__(self, arch):
        super().__init__()
        self.arch, width = arch, arch.text_width
        self.visual = Visual(arch)
        self.token_embedding = nn.Embedding(arch.vocab_size, width)
        nn.init.normal_(self.token_embedding.weight, std=0.02)
        self.positional_embedding = nn.Parameter(
            torch.randn(arch.context_length, width) * 0.01)
        self.transformer = Transformer(width, arch.text_layers,
                                       arch.text_heads)
        self.ln_final = nn.LayerNorm(width)
        self.text_projection = nn.Parameter(
            torch.randn(width, arch.embedding_dim) * width ** -0.5)
        self.logit_scale = nn.Parameter(torch.tensor(math.log(1 / 0.07)))
        mask = torch.full((arch.context_length,) * 2, -math.inf).triu_(1)
        self.register_buffer("mask", mask, persistent=False)

    def encode_image(self, images):
        return F.normalize(self.visual(images)[0], dim=-1)

    def encode_patches(self, images):
        """Vectors of images (N, D) and of their patches (N, n, D)."""
        return (F.normalize(x, dim=-1) for x in self.visual(images))

    def encode_text(self, ids, ends):
        """Texts as token numbers (N, n), the end token at `ends`."""
        x = self.token_embedding(ids) + self.positional_embedding[
            :ids.shape[1]]
        x = self.transformer(x, self.mask)[torch.arange(len(ids)), ends]
        return F.normalize(self.ln_final(x) @ self.text_projection, dim=-1)


def architecture(arguments, vocab_size):
    return Architecture(224, 16, arguments.width, arguments.layers,
                        arguments.heads, 512, arguments.text_width,
                        arguments.text_layers, arguments.text_heads, CONTEXT,
                        vocab_size)


def learn_merges(texts, most):
    """Byte-pair merges, most frequent pair first, ties by spelling."""
    words = Counter(word for text in texts
                    for word in re.findall(r"[a-z]+", text.lower()))
    pieces = {word: [*word[:-1], word[-1] + "</w>"] for word in words}
    merges = []
    while len(merges) < most:
        pairs = Counter()
        for word, parts in pieces.items():
            for pair in zip(parts, parts[1:]):
                pairs[pair] += words[word]
        if not pairs:
            break
        best = max(pairs, key=lambda pair: (pairs[pair], pair))
        merges.append(best)
        for parts in pieces.values():
            i = 0
            while i < len(parts) - 1:
                if (parts[i], parts[i + 1]) == best:
                    parts[i:i + 2] = ["".join(best)]
                i += 1
    return merges


def write_merges(merges, path):
    lines = ["#version: 1, merges of the small model's captions"]
    path.write_text("\n".join(lines + [" ".join(m) for m in merges]) + "\n")


def pad(token_lists):
    """Token numbers as one tensor, and where each text ends."""
    length = max(map(len, token_lists))
    ids = torch.zeros(len(token_lists), length, dtype=torch.long)
    for row, tokens in zip(ids, token_lists):
        row[:len(tokens)] = torch.tensor(tokens)
    return ids, torch.tensor([len(tokens) - 1 for tokens in token_lists])
