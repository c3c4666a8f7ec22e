#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes upsampler.onnx beside this file: an upsampler for tiny_clip that a
test can say the values of. Every cell is repeated 8 x 8 times, and half of
the image's channel c mod 3 is added to channel c. Needs PyTorch."""
from pathlib import Path

import torch
from torch import nn


class Upsampler(nn.Module):
    def __init__(self):
        super().__init__()
        self.colour = nn.Conv2d(3, 8, 1, bias=False)
        self.colour.weight.data.zero_()
        for c in range(8):
            self.colour.weight.data[c, c % 3] = 0.5

    def forward(self, features, image):
        return nn.functional.interpolate(
            features, scale_factor=8, mode="nearest") + self.colour(image)


torch.onnx.export(
    Upsampler(), (torch.zeros(1, 8, 2, 2), torch.zeros(1, 3, 16, 16)),
    str(Path(__file__).parent / "upsampler.onnx"), opset_version=13,
    input_names=["features", "image"], output_names=["output"])
