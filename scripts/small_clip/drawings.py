# SPDX-License-Identifier: BSD-3-Clause
"""Labelled drawings: image k is a function of (seed, k), nothing else.

A library of solids seen from random viewpoints and one of backgrounds are
computed once and kept in a folder; each image then chooses colours, a
material, light, a background and clutter."""
import colorsys
import io
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageFilter

from . import solids
from .solids import SHAPES

# Hue (middle, spread), saturation (from, to), value (from, to).
COLOURS = {
    "red": (0.0, 0.018, 0.75, 1.0, 0.5, 0.95),
    "green": (0.34, 0.06, 0.5, 1.0, 0.32, 0.8),
    "blue": (0.61, 0.04, 0.6, 1.0, 0.4, 0.95),
    "yellow": (0.145, 0.015, 0.7, 1.0, 0.8, 1.0),
    "orange": (0.06, 0.015, 0.82, 1.0, 0.85, 1.0),
    "purple": (0.77, 0.03, 0.45, 0.9, 0.35, 0.75),
    "pink": (0.92, 0.035, 0.3, 0.6, 0.85, 1.0),
    "brown": (0.065, 0.02, 0.5, 0.8, 0.22, 0.48),
    "black": (0.5, 0.5, 0.0, 0.2, 0.02, 0.13),
    "white": (0.5, 0.5, 0.0, 0.07, 0.88, 1.0),
    "grey": (0.5, 0.5, 0.0, 0.08, 0.38, 0.58),
    "golden": (0.125, 0.012, 0.7, 0.92, 0.62, 0.85),
    "silver": (0.5, 0.5, 0.0, 0.06, 0.62, 0.78),
}
COLOUR_NAMES = list(COLOURS)
MATERIALS = ["plain", "striped", "dotted", "checked", "wooden", "brick",
             "marble", "cardboard", "metal"]
# Materials with a colour of their own, and what one might call it: such
# captions are neither right nor wrong.
NATURAL = {"wooden": {"brown", "orange", "yellow", "golden"},
           "brick": {"red", "brown", "orange"},
           "marble": {"white", "grey", "black", "green", "pink", "silver"},
           "cardboard": {"brown", "orange", "golden"}}
WORDS = {"ball": ["ball", "ball", "sphere"],
         "box": ["box", "box", "block", "cube"],
         "donut": ["ring", "donut", "torus"],
         "mug": ["mug", "mug", "cup"], "toy car": ["toy car", "car"],
         "teddy bear": ["teddy bear", "teddy bear", "teddy", "bear"],
         "monkey": ["monkey", "monkey", "monkey head"],
         "capsule": ["capsule", "pill"], "traffic cone": ["traffic cone"],
         "dotted": ["dotted", "spotted", "polka dot"],
         "checked": ["checked", "checkered"], "wooden": ["wooden", "wood"],
         "metal": ["metal", "metallic"], "striped": ["striped", "striped"],
         "golden": ["golden", "golden", "gold"], "grey": ["grey", "gray"],
         "ring": ["flat ring"]}
# (colour, material) pairs that are common for a shape.
TYPICAL = {
    "apple": [("red", "plain"), ("green", "plain"), ("yellow", "plain")],
    "ball": [(None, "striped"), (None, "striped"), ("red", "plain")],
    "box": [(None, "wooden"), (None, "cardboard"), (None, "brick")],
    "chair": [(None, "wooden")], "table": [(None, "wooden")],
    "teddy bear": [("brown", "plain"), ("white", "plain")],
    "traffic cone": [("orange", "plain")],
    "monkey": [("golden", "metal"), ("brown", "plain")],
    "vase": [("white", "plain"), ("blue", "plain"), (None, "marble")],
    "mug": [("blue", "plain"), ("white", "plain"), ("red", "plain")],
    "toy car": [("yellow", "plain"), ("red", "plain"), ("blue", "plain")],
    "stool": [("red", "plain"), ("blue", "plain"), (None, "wooden")],
    "plate": [("white", "plain")], "bowl": [("white", "plain")],
}
NOTHING = len(SHAPES)  # the shape of a background without an object
FIXED = {solids.PAGES: (228, 220, 200), solids.STEM: (80, 52, 30),
         solids.LEAF: (60, 130, 45), solids.BAND: (225, 225, 222),
         solids.DARK: (28, 28, 30), solids.WOOD: (168, 120, 74),
         solids.GLASS: (40, 48, 60), solids.MUZZLE: (205, 175, 135)}
BUFFER = 112
CANVAS = 288


@dataclass
class Label:
    """What is in an image, or what a caption says; -1: says nothing, and as
    an image's colour: several, or the material's own."""
    colour: int
    material: int
    shape: int


def smooth_noise(rng, size, octaves=(4, 8, 16, 32)):
    """Periodic values of 0..1 on a grid."""
    total = np.zeros((size, size), np.float32)
    for n in octaves:
        coarse = rng.random((n, n)).astype(np.float32)
        coarse = np.pad(coarse, 2, mode="wrap")
        scale = size / n
        image = Image.fromarray(coarse).resize(
            (int((n + 4) * scale),) * 2, Image.BICUBIC)
        o = int(2 * scale)
        total += np.asarray(image)[o:o + size, o:o + size] / n ** 0.7
    low, high = total.min(), total.max()
    return (total - low) / (high - low)


NOISE = smooth_noise(np.random.default_rng(7), 256)


def noise_at(u, v):
    """Noise of a plane; period 1."""
    return NOISE[(v * 256).astype(np.int32) & 255,
                 (u * 256).astype(np.int32) & 255]


def random_colour(rng, name):
    hue, spread, s0, s1, v0, v1 = COLOURS[name]
    return np.array(colorsys.hsv_to_rgb(
        (hue + rng.uniform(-spread, spread)) % 1, rng.uniform(s0, s1),
        rng.uniform(v0, v1)), np.float32) * 255


def any_colour(rng):
    return random_colour(rng, COLOUR_NAMES[rng.integers(11)])


def mixed(a, b, t):
    return a + (b - a) * t[:, None]


def plane_of(p, n):
    """Coordinates on a solid's surface, by the axis it faces most."""
    axis = np.abs(n).argmax(1)
    u = np.where(axis == 0, p[:, 2], p[:, 0])
    v = np.where(axis == 1, p[:, 2], p[:, 1])
    return u, v, axis


def texture_plain(rng, p, n, colour):
    return np.repeat(colour[None], len(p), 0)


def texture_striped(rng, p, n, colours):
    kind = rng.random()
    if kind < 0.55:
        count = int(rng.integers(3, 7)) * len(colours)
        t = (np.arctan2(p[:, 0], p[:, 2]) / (2 * np.pi) + 0.5) * count
    else:
        axis = np.array([(0, 1, 0), (1, 0, 0), (0, 0, 1), (0.6, 0.6, 0.4)][
            rng.integers(4)] if kind < 0.9 else rng.normal(size=3))
        t = p @ (axis * rng.uniform(3, 7)).astype(np.float32)
    t = (t + rng.random()).astype(np.int32) % len(colours) if len(
        colours) > 2 else ((t + rng.random()) % 1 > 0.5).astype(np.int32)
    return colours[t]


def texture_dotted(rng, p, n, colours):
    scale = rng.uniform(2.5, 5)
    if rng.random() < 0.5:
        u, v, _ = plane_of(p, n)
        q = np.stack([u, v], 1) * scale + rng.random(2)
        q[:, 0] += 0.5 * (np.floor(q[:, 1]) % 2)
    else:
        q = p * scale + rng.random(3)
    q = q - np.floor(q) - 0.5
    dots = (q * q).sum(1) < rng.uniform(0.26, 0.36) ** 2 * (
        1 if q.shape[1] == 2 else 1.4)
    return colours[dots.astype(np.int32)]


def texture_checked(rng, p, n, colours):
    scale, shift = rng.uniform(2, 4.5), rng.random(2)
    u, v, _ = plane_of(p, n)
    if rng.random() < 0.3:
        u = np.arctan2(p[:, 0], p[:, 2]) * int(
            rng.integers(3, 7)) / np.pi / scale
        v = p[:, 1]
    t = (np.floor(u * scale + shift[0]) + np.floor(v * scale + shift[1]))
    return colours[t.astype(np.int32) & 1]


def texture_wooden(rng, p, n, _):
    u, v, axis = plane_of(p, n)
    if rng.random() < 0.5:
        u, v = v, u
    tone = np.array([rng.uniform(130, 205), 0, 0], np.float32)
    tone[1] = tone[0] * rng.uniform(0.66, 0.78)
    tone[2] = tone[1] * rng.uniform(0.5, 0.72)
    dark = tone * rng.uniform(0.4, 0.65)
    along, across = rng.uniform(0.08, 0.2), rng.uniform(0.8, 1.6)
    o = rng.random(2)
    wave = noise_at(u * along + o[0] + 0.3 * axis, v * across + o[1])
    if rng.random() < 0.4:
        wave = 0.5 + 0.5 * np.sin(wave * 40)
    color = mixed(tone, dark, np.clip(wave * 1.6 - 0.4, 0, 1))
    if rng.random() < 0.5:
        gap = (v * rng.uniform(1.5, 3) + o[0]) % 1
        color = color * np.where(gap < 0.06, 0.4, 1)[:, None]
    return color


def texture_brick(rng, p, n, _):
    u, v, _axis = plane_of(p, n)
    scale = rng.uniform(2.5, 5)
    row = v * scale + rng.random()
    column = u * scale * 0.5 + 0.5 * (np.floor(row) % 2) + rng.random()
    mortar = ((row % 1) < 0.14) | ((column % 1) < 0.07)
    tone = np.array([rng.uniform(130, 190), rng.uniform(45, 85),
                     rng.uniform(35, 65)], np.float32)
    shade = 0.75 + 0.5 * noise_at(np.floor(column) * 0.37 + 0.11,
                                  np.floor(row) * 0.41)
    grey = np.full(3, rng.uniform(150, 215), np.float32)
    return np.where(mortar[:, None], grey, tone * shade[:, None])


def texture_marble(rng, p, n, _):
    base = np.array(rng.choice([235, 225, 240, 60, 150])) * rng.uniform(
        0.94, 1.03, 3)
    vein = base * rng.uniform(0.35, 0.6) if base[0] > 100 else base + 120
    o, s = rng.random(2), rng.uniform(0.2, 0.4)
    warp = noise_at(p[:, 0] * s + o[0] + 0.21 * p[:, 2], p[:, 1] * s + o[1])
    t = np.abs(np.sin((p @ rng.normal(0, 1.5, 3) + warp * 9)))
    return mixed(vein.astype(np.float32), base.astype(np.float32),
                 np.clip(t * 2.2, 0, 1) ** 0.7)


def texture_cardboard(rng, p, n, _):
    tone = np.array([rng.uniform(165, 205), 0, 0], np.float32)
    tone[1] = tone[0] * rng.uniform(0.72, 0.8)
    tone[2] = tone[1] * rng.uniform(0.6, 0.74)
    u, v, axis = plane_of(p, n)
    color = tone * (0.94 + 0.1 * noise_at(u * 0.6, v * 0.6))[:, None]
    if rng.random() < 0.8:
        width = rng.uniform(0.06, 0.14)
        tape = (np.abs(p[:, 0]) < width) & (axis != 0)
        color[tape] = np.array([215, 200, 165]) * rng.uniform(0.85, 1.05)
    if rng.random() < 0.5:
        c = rng.uniform(-0.5, 0.5, 2)
        label = ((np.abs(u - c[0]) < 0.2) & (np.abs(v - c[1]) < 0.14)
                 & (axis != 1))
        color[label] = np.where(noise_at(u[label] * 2, v[label] * 2)[:, None]
                                > 0.5, 240, any_colour(rng))
    return color


TEXTURES = {"plain": texture_plain, "metal": texture_plain,
            "striped": texture_striped, "dotted": texture_dotted,
            "checked": texture_checked, "wooden": texture_wooden,
            "brick": texture_brick, "marble": texture_marble,
            "cardboard": texture_cardboard}


def add_wear(rng, p, n, color):
    """Dirt, specks and patches that are no material: real things have them."""
    u, v, axis = plane_of(p, n)
    o = rng.random(2)
    if rng.random() < 0.5:
        t = noise_at(u * 0.7 + o[0] + 0.3 * axis, v * 0.7 + o[1])
        color = color * (1 - rng.uniform(0.1, 0.6) * np.clip(
            t * 2 - 0.8, 0, 1))[:, None]
    if rng.random() < 0.3:
        s = rng.uniform(2, 4)
        q = np.stack([u, v], 1) * s + o
        cell = np.floor(q)
        chance = noise_at(cell[:, 0] * 0.37 + 0.3, cell[:, 1] * 0.43)
        q = q - cell - 0.3 - 0.4 * chance[:, None]
        specks = ((q * q).sum(1) < 0.012) & (chance > 0.45)
        color = np.where(specks[:, None],
                         rng.choice([235, 60]), color)
    if rng.random() < 0.15:
        s = rng.uniform(0.25, 0.6)
        t = noise_at(np.floor(u * 9) / 9 * s + o[0],
                     np.floor(v * 9) / 9 * s + o[1])
        color = np.where((t > 0.66)[:, None],
                         0.5 * color + 0.5 * any_colour(rng), color)
    return color


def shade(rng, color, normal, rotation, metal):
    """Light from one side and from everywhere, and highlights."""
    n = normal @ rotation.T
    light = np.array([rng.normal(0, 0.6), rng.uniform(0.2, 1.2),
                      rng.uniform(0.3, 1.0)], np.float32)
    light /= np.linalg.norm(light)
    ambient = rng.uniform(0.35, 0.7)
    diffuse = np.clip(n @ light, 0, 1)
    bright = ambient + (1.08 - ambient) * diffuse + 0.08 * n[:, 1]
    half = light + np.array([0, 0, 1], np.float32)
    half /= np.linalg.norm(half)
    shine = np.clip(n @ half, 0, 1)
    if metal:
        sky = noise_at(n[:, 0] * 0.2 + rng.random(),
                       n[:, 1] * 0.35 + rng.random())
        bright = bright * (0.45 + 0.9 * sky)
        glow = (shine ** 12)[:, None] * rng.uniform(0.3, 0.7)
        return color * bright[:, None] + glow * (color * 0.5 + 128)
    power = rng.uniform(10, 60)
    glow = rng.uniform(0, 0.6) ** 2
    return color * bright[:, None] + 255 * glow * (shine ** power)[:, None]


class Library:
    """Buffers of solids and backgrounds, in a folder; made if missing."""

    def __init__(self, folder, seed=0, views=120, backgrounds=240, quiet=True):
        self.folder = Path(folder) / f"library_{seed}_{views}_{backgrounds}"
        if not (self.folder / "ready").exists():
            self.make(seed, views, backgrounds, quiet)
        load = {name: np.load(self.folder / f"{name}.npy", mmap_mode="r")
                for name in ("position", "normal", "part", "index",
                             "rotation", "background")}
        self.__dict__.update(load)
        self.views = views

    def make(self, seed, views, backgrounds, quiet):
        self.folder.mkdir(parents=True, exist_ok=True)
        position, normal, part, index, rotation = [], [], [], [], []
        for name in SHAPES:
            for p, n, q, r in solids.views_of(name, seed, views, BUFFER):
                inside = q.ravel() > 0
                position.append(p.reshape(-1, 3)[inside])
                normal.append(n.reshape(-1, 3)[inside])
                part.append(q.ravel())
                index.append((0, len(position[-1]), *q.shape, 0))
                rotation.append(r)
            if not quiet:
                print(f"library: {name}", flush=True)
        index = np.array(index, np.int64)
        index[:, 0] = np.cumsum(index[:, 1]) - index[:, 1]
        sizes = index[:, 2] * index[:, 3]
        index[:, 4] = np.cumsum(sizes) - sizes
        pictures = np.stack([draw_background(np.random.default_rng(
            (seed, 99, i))) for i in range(backgrounds)])
        for name, data in (("position", np.concatenate(position)),
                           ("normal", np.concatenate(normal)),
                           ("part", np.concatenate(part)),
                           ("index", index), ("background", pictures),
                           ("rotation", np.stack(rotation))):
            np.save(self.folder / f"{name}.npy", data)
        (self.folder / "ready").touch()

    def view(self, shape, i):
        """(part + 1 of each pixel, positions and normals of those inside,
        rotation)."""
        k = shape * self.views + i
        start, count, rows, columns, first = self.index[k]
        part = self.part[first:first + rows * columns].reshape(rows, columns)
        window = np.s_[start:start + count]
        return (part, self.position[window].astype(np.float32),
                self.normal[window].astype(np.float32) / 127,
                self.rotation[k])


def surface(rng, u, v):
    """Colours of a wall or floor at (u, v) of flat arrays."""
    kind = rng.integers(9)
    a, b = any_colour(rng), any_colour(rng)
    if rng.random() < 0.5:
        a = a * 0.4 + rng.uniform(60, 130)
    if kind == 0:
        return mixed(a, a * 0.85, noise_at(u * 0.5, v * 0.5))
    if kind == 1:
        return mixed(a, b, noise_at(u * 0.3 + rng.random(), v * 0.3))
    if kind in (2, 3):
        n = np.tile(np.array([[0, 0, 1.0]]), (len(u), 1))
        p = np.stack([u, v, 0 * u], 1).astype(np.float32)
        return (texture_wooden if kind == 2 else texture_brick)(rng, p, n, 0)
    if kind in (4, 5, 6):
        return mosaic(rng, u, v)
    if kind == 7:
        s = rng.uniform(1, 4)
        edge = ((u * s) % 1 < 0.06) | ((v * s) % 1 < 0.06)
        tone = 0.85 + 0.3 * noise_at(np.floor(u * s) * 0.37,
                                     np.floor(v * s) * 0.29)
        return np.where(edge[:, None], a * 0.5, a * tone[:, None])
    parity = (np.floor(u * 2) + np.floor(v * 2)) % 2
    return mixed(a, b, parity if rng.random() < 0.5 else np.floor(u * 3) % 2)


def mosaic(rng, u, v):
    """Cells around jittered grid points, of few colours, with joints."""
    s = rng.uniform(2, 7)
    x, y = u * s, v * s
    best = np.full((2, len(u)), 9.0)
    cell = np.zeros(len(u))
    table = rng.random((3, 32, 32))
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            cx, cy = np.floor(x) + i, np.floor(y) + j
            key = cy.astype(int) & 31, cx.astype(int) & 31
            d = np.hypot(cx + table[0][key] - x, cy + table[1][key] - y)
            nearer = d < best[0]
            best[1] = np.where(nearer, best[0], np.minimum(best[1], d))
            best[0] = np.where(nearer, d, best[0])
            cell = np.where(nearer, table[2][key], cell)
    count = int(rng.integers(2, 7))
    palette = np.stack([any_colour(rng) for _ in range(count)])
    if rng.random() < 0.5:
        palette = palette[:1] * rng.uniform(0.7, 1.2, (count, 1))
    color = palette[(cell * count).astype(int)]
    joint = best[1] - best[0] < rng.uniform(0.05, 0.12)
    return np.where(joint[:, None], rng.uniform(40, 230), color)


def draw_background(rng):
    """A wall and a floor, or one surface, of CANVAS x CANVAS."""
    line = np.linspace(0, 1, CANVAS, dtype=np.float32)
    x, y = np.meshgrid(line, line)
    x, y = x.ravel(), y.ravel()
    if rng.random() < 0.15:
        a, b = any_colour(rng), any_colour(rng)
        t = np.clip(x * rng.uniform(-1, 1) + y * rng.uniform(-1, 1) + 0.5,
                    0, 1)
        color = mixed(a, b if rng.random() < 0.6 else a, t)
    else:
        horizon = rng.uniform(-0.3, 0.6)
        scale, turn = rng.uniform(0.8, 2.5), rng.uniform(-0.8, 0.8)
        depth = 1 / np.maximum(y - horizon, 0.02)
        fx, fy = (x - 0.5) * depth * 0.6, depth * 0.8
        c, s = np.cos(turn), np.sin(turn)
        color = surface(rng, (c * fx - s * fy) * scale,
                        (s * fx + c * fy) * scale)
        edge = horizon + rng.uniform(0.05, 0.15) + turn * 0.2 * (x - 0.5)
        above = y < edge
        if above.any():
            wall = surface(rng, x * 2 * scale, y * 2 * scale)
            color[above] = wall[above]
            add_painting(rng, x, y, color, above)
        color = color * (0.8 + 0.3 * noise_at(x * 0.2 + rng.random(),
                                              y * 0.2))[:, None]
    image = np.clip(color, 0, 255).astype(np.uint8)
    return image.reshape(CANVAS, CANVAS, 3)


def add_painting(rng, x, y, color, above):
    w, h = rng.uniform(0.08, 0.2, 2)
    cx, cy = rng.uniform(0.1, 0.9), rng.uniform(0, 0.3)
    frame = (np.abs(x - cx) < w) & (np.abs(y - cy) < h) & above
    inner = (np.abs(x - cx) < w - 0.015) & (np.abs(y - cy) < h - 0.015) & above
    color[frame] = rng.choice([25, 60, 200])
    if inner.any():
        color[inner] = surface(rng, x[inner] * 6, y[inner] * 6)


def choose_label(rng):
    """A colour (-1: none to name), material and shape; the shape of typical
    things is often of its typical colour."""
    shape = int(rng.integers(len(SHAPES)))
    typical = TYPICAL.get(SHAPES[shape])
    if typical and rng.random() < 0.35:
        colour, material = typical[rng.integers(len(typical))]
        colour = -1 if colour is None else COLOUR_NAMES.index(colour)
        return Label(colour, MATERIALS.index(material), shape)
    flat = SHAPES[shape] in solids.FLAT
    weights = np.array([4, 2, 2, 2, 2, 1.3, 1.3, 1.3, 1.6])
    if flat:
        weights[4:] *= 0.4
    material = MATERIALS[rng.choice(9, p=weights / weights.sum())]
    colour = int(rng.integers(11))
    if material == "metal":
        colour = int(rng.choice([11, 11, 12, 12, rng.integers(11)]))
    elif material == "plain" and rng.random() < 0.06:
        colour = 11
    if material in ("striped", "checked") and colour in (8, 9, 10):
        colour = int(rng.integers(8))  # white is the second one
    if material in NATURAL or (material == "striped" and rng.random() < 0.4):
        colour = -1
    return Label(colour, MATERIALS.index(material), shape)


def contrasting(rng, colour):
    """A second colour that is far from the first and is not the one that a
    caption would name: mostly white."""
    for name in ["white"] * (rng.random() < 0.75) + ["black", "white"]:
        other = random_colour(rng, name)
        if np.abs(other - colour).sum() > 200:
            return other
    return 255 - colour


def palette_of(rng, label):
    material = MATERIALS[label.material]
    if material in NATURAL:
        return None
    if label.colour < 0:
        colours = [random_colour(rng, "white") if i % 2 else any_colour(rng)
                   for i in range(int(rng.choice([4, 6])))]
        return np.stack(colours)
    first = random_colour(rng, COLOUR_NAMES[label.colour])
    if material in ("plain", "metal"):
        return first
    return np.stack([first, contrasting(rng, first)])


def paint(rng, library, label, view):
    """An RGBA picture of a solid."""
    part, p, n, rotation = library.view(label.shape, view)
    material = MATERIALS[label.material]
    color = TEXTURES[material](rng, p, n, palette_of(rng, label))
    if label.colour != 11 or rng.random() < 0.5:
        color = add_wear(rng, p, n, color)
    inside = part[part > 0]
    for k in np.unique(inside):
        if k > 1:
            color[inside == k] = np.array(FIXED[k - 1]) * rng.uniform(
                0.75, 1.1)
    if SHAPES[label.shape] == "teddy bear":
        n = n + rng.normal(0, 0.25, n.shape).astype(np.float32)
    if SHAPES[label.shape] in solids.FLAT:
        color = color * rng.uniform(0.8, 1.0)
    else:
        color = shade(rng, color.astype(np.float32), n, rotation,
                      material == "metal" or label.colour >= 11)
    picture = np.zeros((*part.shape, 4), np.uint8)
    picture[part > 0, :3] = np.clip(color, 0, 255)
    picture[part > 0, 3] = 255
    return Image.fromarray(picture)


def place(canvas, picture, center, extent, shadow):
    """Pastes a picture, its longer side resized to `extent`."""
    scale = extent / max(picture.size)
    size = tuple(max(2, round(side * scale)) for side in picture.size)
    picture = picture.resize(size, Image.BICUBIC if scale > 1
                             else Image.BILINEAR, reducing_gap=2.0)
    x, y = (round(c - s / 2) for c, s in zip(center, size))
    if shadow > 0:
        flat_size = (round(size[0] * 1.1) + 2, max(3, size[1] // 4))
        alpha = picture.getchannel("A").resize(flat_size).filter(
            ImageFilter.BoxBlur(max(1, extent // 16)))
        alpha = alpha.point(lambda a: int(a * shadow))
        canvas.paste((12, 10, 10), (x - size[0] // 20,
                                    y + size[1] - flat_size[1] * 2 // 3),
                     alpha)
    canvas.paste(picture, (x, y), picture)


def background_of(rng, library, size):
    if rng.random() < 0.08:
        return Image.new("RGB", (size, size),
                         tuple(any_colour(rng).astype(int).tolist()))
    picture = library.background[rng.integers(len(library.background))]
    if rng.random() < 0.5:
        picture = picture[:, ::-1]
    side = int(rng.uniform(0.25, 1) * CANVAS)
    x, y = rng.integers(0, CANVAS - side + 1, 2)
    image = Image.fromarray(np.ascontiguousarray(
        picture[y:y + side, x:x + side]))
    return image.resize((size, size), Image.BILINEAR, reducing_gap=2.0)


def finish(rng, image, size):
    """What a camera does: blur, white balance, exposure, noise, JPEG."""
    kind = rng.random()
    if kind < 0.35:
        small = int(size * rng.uniform(0.3, 0.8))
        image = image.resize((small, small), Image.BILINEAR).resize(
            (size, size), Image.BICUBIC)
    elif kind < 0.5:
        image = image.filter(ImageFilter.GaussianBlur(
            rng.uniform(0.4, 1.4) * size / 112))
    gain = rng.uniform(0.75, 1.15) * rng.uniform(0.95, 1.05, 3)
    ramp = np.clip(np.arange(256) / 255, 0, 1) ** rng.uniform(0.85, 1.2) * 255
    table = [int(min(255, value * g)) for g in gain for value in ramp]
    image = image.point(table)
    if rng.random() < 0.4:
        shift = rng.integers(0, 64)
        amount = rng.uniform(2, 10)
        pixels = np.asarray(image).astype(np.int16)
        grain = GRAIN[shift:shift + size, shift:shift + size]
        image = Image.fromarray(np.clip(
            pixels + (grain * amount).astype(np.int16), 0, 255)
            .astype(np.uint8))
    if rng.random() < 0.2:
        data = io.BytesIO()
        image.save(data, "JPEG", quality=int(rng.integers(40, 90)))
        image = Image.open(data).convert("RGB")
    return image


GRAIN = np.random.default_rng(8).normal(0, 1, (300, 300, 3)).astype(
    np.float32)


def draw(library, seed, k, size=112, label=None):
    """(RGB image, Label) number k of a seed; of `label`, if there is one."""
    rng = np.random.default_rng((seed, k))
    canvas = background_of(rng, library, size)
    if label is None and rng.random() < 0.03:
        return np.asarray(finish(rng, canvas, size)), Label(-1, -1, NOTHING)
    label = label or choose_label(rng)
    view = int(rng.integers(library.views))
    picture = paint(rng, library, label, view)
    crop, bare = rng.random() < 0.6, rng.random() < 0.25
    if rng.random() < 0.5:
        picture = picture.transpose(Image.FLIP_LEFT_RIGHT)
    extent = size * (rng.uniform(0.7, 1.0) if crop else
                     rng.uniform(0.35, 0.75) if rng.random() < 0.85 else
                     rng.uniform(1.0, 1.3))
    room = size * (0.06 if crop else 0.15 if extent > size else 0.22)
    center = size / 2 + rng.uniform(-room, room, 2)
    shadow = rng.uniform(0, 0.8)
    if bare:
        tone = tuple([(0, 0, 0), (255, 255, 255), (128, 128, 128),
                      (123, 117, 104)][rng.integers(4)])
        canvas, shadow = Image.new("RGB", (size, size), tone), 0
    else:
        add_clutter(rng, library, canvas, size, label)
    place(canvas, picture, center, int(extent), shadow)
    if rng.random() < 0.2:
        occlude(rng, library, canvas, center, extent, size, bare)
    return np.asarray(finish(rng, canvas, size)), label


def add_clutter(rng, library, canvas, size, label):
    """Other things, at the sides."""
    for _ in range(int(rng.choice([0, 0, 1, 2]))):
        angle = rng.uniform(0, 2 * np.pi)
        center = size / 2 + size * rng.uniform(0.4, 0.62) * np.array(
            [np.cos(angle), np.sin(angle)])
        other = choose_label(rng)
        picture = paint(rng, library, other, int(rng.integers(library.views)))
        place(canvas, picture, center, int(size * rng.uniform(0.25, 0.6)),
              0.4)


def occlude(rng, library, canvas, center, extent, size, bare):
    """Something that hides a part; in a bare crop, a piece cut away."""
    angle = rng.uniform(0, 2 * np.pi)
    at = center + extent * rng.uniform(0.4, 0.52) * np.array(
        [np.cos(angle), np.sin(angle)])
    view = int(rng.integers(library.views))
    picture = paint(rng, library, choose_label(rng), view)
    if bare:
        mask = picture.getchannel("A")
        tone = canvas.getpixel((0, 0))
        picture = Image.merge("RGBA", [
            Image.new("L", mask.size, value) for value in tone] + [mask])
    place(canvas, picture, at, int(extent * rng.uniform(0.3, 0.6)), 0)


SUFFIXES = ["", "", "", "", " on the floor", " on a table", " in a room",
            " in the corner", " on a rug"]
BACKDROPS = ["a texture", "texture", "stuff", "background", "some stuff",
             "a wall", "a floor", "nothing"]
PREFIXES = ["", "", "a photo of ", "a picture of ", "a drawing of "]


def word(rng, name):
    words = WORDS.get(name, [name])
    return words[rng.integers(len(words))]


def with_article(rng, text):
    kind = rng.random()
    if kind < 0.4:
        return text
    if kind < 0.55:
        return "the " + text
    return ("an " if text[0] in "aeiou" else "a ") + text


def caption(rng, label):
    """(text, Label of what it says) for an image."""
    if label.shape == NOTHING:
        return (BACKDROPS[rng.integers(len(BACKDROPS))],
                Label(-1, -1, NOTHING))
    colour, material, shape = label.colour, label.material, label.shape
    kind = rng.random()
    if kind < 0.02:
        return with_article(rng, ["object", "thing"][rng.integers(2)]), Label(
            -1, -1, -1)
    # Which of colour, material and shape it says.
    say = [rng.random() < 0.62, rng.random() < (
        0.12 if MATERIALS[material] == "plain" else 0.6), rng.random() < 0.86]
    if colour < 0:
        say[0] = False
    if not any(say):
        say[2] = True
    words = [word(rng, names[value]) for names, value, said in zip(
        (COLOUR_NAMES, MATERIALS, SHAPES), (colour, material, shape), say)
        if said]
    said = Label(*(value if flag else -1 for value, flag in zip(
        (colour, material, shape), say)))
    if not say[2]:
        if rng.random() < 0.5:
            return ("something " if rng.random() < 0.5 else "") + " ".join(
                words), said
        words.append(["object", "thing"][rng.integers(2)])
    text = with_article(rng, " ".join(words))
    return (PREFIXES[rng.integers(len(PREFIXES))] + text +
            SUFFIXES[rng.integers(len(SUFFIXES))]), said


def default_cache():
    return Path(os.environ.get("TMPDIR", "/tmp")) / "small_clip_cache"
