#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws holdout PSNR against training time as an SVG, seconds on a log scale.

    bench/plot_curves.py OUT.svg TITLE NAME=CURVE.csv ...

CURVE.csv has the columns seconds and holdout_psnr, as freegs_training_benchmark
curve prints them; a file of one row is drawn as a point.
"""
import csv
import math
import sys
from xml.sax.saxutils import escape

WIDTH, HEIGHT = 760, 440
LEFT, RIGHT, TOP, BOTTOM = 56, 170, 40, 48
COLORS = ["#1b6ca8", "#2a9d5c", "#8e44ad", "#c0392b", "#d98200", "#555555"]


def read_curve(path):
    with open(path, newline="") as file:
        lines = [l for l in file if "," in l]
    rows = [(float(r["seconds"]), float(r["holdout_psnr"]))
            for r in csv.DictReader(lines) if r["holdout_psnr"]]
    return [(s, p) for s, p in rows if s > 0]


def main():
    out, title, *arguments = sys.argv[1:]
    curves = []
    for argument in arguments:
        name, path = argument.split("=", 1)
        curves.append((name, read_curve(path)))
    points = [p for _, curve in curves for p in curve]
    low_x = math.log10(min(s for s, _ in points))
    high_x = math.log10(max(s for s, _ in points)) + 0.03
    low_y = math.floor(max(min(p for _, p in points), 14))
    high_y = math.ceil(max(p for _, p in points))

    def place(seconds, psnr):
        x = (math.log10(seconds) - low_x) / (high_x - low_x)
        y = (max(psnr, low_y) - low_y) / (high_y - low_y)
        return (LEFT + x * (WIDTH - LEFT - RIGHT),
                HEIGHT - BOTTOM - y * (HEIGHT - TOP - BOTTOM))

    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" '
           f'height="{HEIGHT}" font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
           f'<text x="{LEFT}" y="22" font-size="15">{escape(title)}</text>']
    for psnr in range(low_y, high_y + 1, 2):
        x, y = place(10 ** low_x, psnr)
        svg.append(f'<path d="M{x:.1f} {y:.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>'
                   f'<text x="{x - 8:.1f}" y="{y + 4:.1f}" '
                   f'text-anchor="end">{psnr}</text>')
    for power in range(math.floor(low_x), math.ceil(high_x) + 1):
        for digit in (1, 2, 5):
            seconds = digit * 10.0 ** power
            if not low_x <= math.log10(seconds) <= high_x:
                continue
            x, y = place(seconds, low_y)
            svg.append(f'<path d="M{x:.1f} {TOP}V{y:.1f}" stroke="#eee"/>'
                       f'<text x="{x:.1f}" y="{y + 18:.1f}" '
                       f'text-anchor="middle">{seconds:g}</text>')
    svg.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 10}" '
               'text-anchor="middle">seconds of training (2 threads)</text>'
               f'<text x="14" y="{TOP - 6}">dB</text>')
    labels = []
    for (name, curve), color in zip(curves, COLORS * 3):
        at = [place(*p) for p in curve]
        path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in at)
        svg.append(f'<path d="{path}" fill="none" stroke="{color}" '
                   'stroke-width="2"/>')
        x, y = at[-1]
        svg.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{color}"/>')
        labels.append([y, x, name, curve[-1][1], color])
    # Labels stand at the right, apart from each other.
    labels.sort()
    bottom = TOP
    for y, x, name, psnr, color in labels:
        at = max(y, bottom)
        bottom = at + 16
        svg.append(f'<text x="{WIDTH - RIGHT + 10}" y="{at + 4:.1f}" '
                   f'fill="{color}">{escape(name)} {psnr:.1f}</text>')
    svg.append("</svg>")
    with open(out, "w") as file:
        file.write("\n".join(svg) + "\n")


if __name__ == "__main__":
    main()
