# SPDX-License-Identifier: BSD-3-Clause
"""Labelled drawings: image k is a function of (seed, k), nothing else.

A library of solids seen from random viewpoints and one of backgrounds are
computed once and kept in a folder; each image then chooses colours, a
material, light, a background and clutter."""
import io
import os
from pathlib import Path

import numpy as np
from PIL import Image, ImageFilter

from . import solids
from .backgrounds import CANVAS, draw_background
from .solids import SHAPES
from .textures import (add_wear, any_colour, random_colour, shade, sheen,
                       TEXTURES)
from .vocabulary import (choose_label, COLOUR_NAMES, Label, MATERIALS,
                         NATURAL, NOTHING)

FIXED = {solids.PAGES: (228, 220, 200), solids.STEM: (80, 52, 30),
         solids.LEAF: (60, 130, 45), solids.BAND: (225, 225, 222),
         solids.DARK: (28, 28, 30), solids.WOOD: (168, 120, 74),
         solids.GLASS: (40, 48, 60), solids.MUZZLE: (205, 175, 135)}
BUFFER = 112
PATCH = 16


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
    # Dirt on what mirrors looks like what it mirrors, or like plain things.
    if material != "metal" or rng.random() < 0.3:
        color = add_wear(rng, p, n, color)
    inside = part[part > 0]
    for k in np.unique(inside):
        if k > 1:
            color[inside == k] = np.array(FIXED[k - 1]) * rng.uniform(
                0.75, 1.1)
    if SHAPES[label.shape] == "teddy bear":
        n = n + rng.normal(0, 0.25, n.shape).astype(np.float32)
    metal = material == "metal"
    if SHAPES[label.shape] not in solids.FLAT:
        color = shade(rng, color.astype(np.float32), p, n, rotation, metal)
    elif metal:
        color = sheen(rng, color.astype(np.float32), p)
    else:
        color = color * rng.uniform(0.8, 1.0)
    picture = np.zeros((*part.shape, 4), np.uint8)
    picture[part > 0, :3] = np.clip(color, 0, 255)
    picture[part > 0, 3] = 255
    return Image.fromarray(picture)


def place(canvas, picture, center, extent, shadow, cover=None, value=255):
    """Pastes a picture, its longer side resized to `extent`; into `cover`
    goes `value` where the picture is."""
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
    if cover is not None:
        cover.paste(value, (x, y), picture)


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
    return draw_and_cover(library, seed, k, size, label)[:2]


def draw_and_cover(library, seed, k, size=112, label=None):
    """draw(), and the share of each patch of 16 x 16 pixels, from 0 to 255,
    that shows the thing."""
    cover = Image.new("L", (size, size))
    image, label = draw_on(cover, library, seed, k, size, label)
    cells = np.asarray(cover, np.float32).reshape(
        size // PATCH, PATCH, size // PATCH, PATCH).mean((1, 3))
    return image, label, np.round(cells).astype(np.uint8)


def draw_on(cover, library, seed, k, size, label):
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
    place(canvas, picture, center, int(extent), shadow, cover)
    if rng.random() < 0.2:
        occlude(rng, library, canvas, cover, center, extent, bare)
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


def occlude(rng, library, canvas, cover, center, extent, bare):
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
    place(canvas, picture, at, int(extent * rng.uniform(0.3, 0.6)), 0, cover,
          0)


def default_cache():
    return Path(os.environ.get("TMPDIR", "/tmp")) / "small_clip_cache"
