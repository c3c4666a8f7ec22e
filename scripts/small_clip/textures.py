# SPDX-License-Identifier: BSD-3-Clause
"""Colours of a surface: materials, wear and light."""
import colorsys

import numpy as np
from PIL import Image

from .vocabulary import COLOUR_NAMES, COLOURS


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


def wide_axes(p):
    """Along which axes a solid is more than a sheet: a pattern that changes
    along another would not be seen."""
    return np.ptp(p, axis=0) > 0.3


def texture_plain(rng, p, n, colour):
    return np.repeat(colour[None], len(p), 0)


def texture_striped(rng, p, n, colours):
    kind, wide = rng.random(), wide_axes(p)
    if kind < 0.55 and wide[0] and wide[2]:
        count = int(rng.integers(3, 7)) * len(colours)
        t = (np.arctan2(p[:, 0], p[:, 2]) / (2 * np.pi) + 0.5) * count
    else:
        axes = [*np.eye(3)[wide], (0.6, 0.6, 0.4)]
        axis = np.array(axes[rng.integers(len(axes))] if kind < 0.9
                        else rng.normal(size=3))
        t = p @ (axis * rng.uniform(3, 7)).astype(np.float32)
    t = (t + rng.random()).astype(np.int32) % len(colours) if len(
        colours) > 2 else ((t + rng.random()) % 1 > 0.5).astype(np.int32)
    return colours[t]


def texture_dotted(rng, p, n, colours):
    scale = rng.uniform(2.5, 5)
    if rng.random() < 0.5 or not wide_axes(p).all():
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
    wide = wide_axes(p)
    if rng.random() < 0.3 and wide[0] and wide[2]:
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
        amount = rng.uniform(0.1, 0.6) * np.clip(t * 2 - 0.8, 0, 1)
        # Dirt is brown: with grey dirt a white thing looks like silver.
        color = color * (1 - amount[:, None] * np.float32([0.75, 0.95, 1.2]))
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


def sheen(rng, color, p):
    """Sheet metal: bright and dark bands across."""
    angle = rng.uniform(0, np.pi)
    along = p[:, 0] * np.cos(angle) + p[:, 1] * np.sin(angle)
    bands = sum(np.sin(k * rng.uniform(1.5, 3) * along +
                       rng.uniform(0, 6.3)) / k for k in (1, 2, 4)) / 1.75
    glow = (np.clip(bands, 0, 1) ** 2 * rng.uniform(0.4, 0.8))[:, None]
    return (color * mirrored(0.5 + 0.5 * bands)[:, None] +
            glow * (color * 0.3 + 80))


def mirrored(t):
    """What metal mirrors, of values about 0.5: a dark room and bright windows
    with little between them, as nothing dull has."""
    return 0.35 + 0.85 / (1 + np.exp(9 * (0.5 - t)))


def shade(rng, color, p, normal, rotation, metal):
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
        # What is mirrored changes across flat faces, too.
        sky = mirrored(noise_at(
            n[:, 0] * 0.2 + p[:, 0] * 0.35 + rng.random(),
            n[:, 1] * 0.35 + p[:, 1:].sum(1) * 0.35 + rng.random()))
        bright = bright * sky * 1.1
        glow = (shine ** 12 * sky)[:, None] * rng.uniform(0.2, 0.5)
        return color * bright[:, None] + glow * (color * 0.5 + 128)
    power = rng.uniform(10, 60)
    glow = rng.uniform(0, 0.6) ** 2
    return color * bright[:, None] + 255 * glow * (shine ** power)[:, None]
