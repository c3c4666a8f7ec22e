# SPDX-License-Identifier: BSD-3-Clause
"""What stands behind the drawn things: floors, walls, paintings."""
import numpy as np

from .textures import (any_colour, mixed, noise_at, texture_brick,
                       texture_wooden)

CANVAS = 288  # pixels of a side of a kept background


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
