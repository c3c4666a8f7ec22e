# SPDX-License-Identifier: BSD-3-Clause
"""Small convolutions from an image to its patches of 16 x 16 pixels."""
import torch.nn.functional as F
from torch import nn

# Channels at a half, a quarter and an eighth of the image's size, and how many
# residual pairs of convolutions there.
STAGES = [(16, 0), (32, 1), (64, 3)]


class Residual(nn.Module):
    def __init__(self, width):
        super().__init__()
        self.first = nn.Conv2d(width, width, 3, 1, 1)
        self.second = nn.Conv2d(width, width, 3, 1, 1)
        nn.init.kaiming_normal_(self.first.weight, nonlinearity="relu")
        nn.init.zeros_(self.first.bias)
        nn.init.zeros_(self.second.weight)
        nn.init.zeros_(self.second.bias)

    def forward(self, x):
        return x + self.second(F.relu(self.first(F.relu(x))))


def make_stem(width):
    """They stand beside CLIP's one linear map of a patch, and find edges and
    their bends in far fewer drawings than it alone (Xiao et al., Early
    Convolutions Help Transformers See Better, 2021)."""
    layers, before = [], 3
    for channels, pairs in [*STAGES, (width, 0)]:
        conv = nn.Conv2d(before, channels, 3, 2, 1)
        nn.init.kaiming_normal_(conv.weight, nonlinearity="relu")
        nn.init.zeros_(conv.bias)
        layers += [conv, *(Residual(channels) for _ in range(pairs)),
                   nn.ReLU()]
        before = channels
    return nn.Sequential(*layers[:-1])
