#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws quality against time as an SVG, seconds on a log scale.

    bench/plot_curves.py OUT.svg TITLE NAME=CURVE.csv ...

CURVE.csv has the columns seconds and holdout_psnr, as freegs_training_benchmark
curve prints them, or those that --x and --y name; a file of one row is drawn as
a point. What lies below --low is drawn at the lower edge.
"""
import argparse
import csv
import math
from xml.sax.saxutils import escape

WIDTH, HEIGHT = 760, 440
LEFT, RIGHT, TOP, BOTTOM = 56, 170, 40, 48
COLORS = ["#1b6ca8", "#2a9d5c", "#8e44ad", "#c0392b", "#d98200", "#555555"]


def read_curve(path, x, y):
    with open(path, newline="") as file:
        lines = [l for l in file if "," in l]
    rows = [(float(r[x]), float(r[y])) for r in csv.DictReader(lines) if r[y]]
    return [(s, p) for s, p in rows if s > 0]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out")
    parser.add_argument("title")
    parser.add_argument("curves", nargs="+", metavar="NAME=CURVE.csv")
    parser.add_argument("--x", default="seconds", help="column")
    parser.add_argument("--x-label", default="seconds of training (2 threads)")
    parser.add_argument("--y", default="holdout_psnr", help="column")
    parser.add_argument("--y-label", default="dB")
    parser.add_argument("--low", type=float, help="of the chart; 14 or more dB")
    parser.add_argument("--high", type=float)
    parser.add_argument("--step", type=float, default=2, help="of the grid")
    parser.add_argument("--dots", action="store_true",
                        help="one per row instead of a line")
    args = parser.parse_args()
    curves = []
    for argument in args.curves:
        name, path = argument.split("=", 1)
        curve = read_curve(path, args.x, args.y)
        curves.append((name, sorted(curve) if args.dots else curve))
    points = [p for _, curve in curves for p in curve]
    low_x = math.log10(min(s for s, _ in points))
    high_x = math.log10(max(s for s, _ in points)) + 0.03
    low_y, high_y = args.low, args.high
    if low_y is None:
        low_y = math.floor(max(min(p for _, p in points), 14))
    if high_y is None:
        high_y = math.ceil(max(p for _, p in points))

    def place(seconds, psnr):
        x = (math.log10(seconds) - low_x) / (high_x - low_x)
        y = (max(psnr, low_y) - low_y) / (high_y - low_y)
        return (LEFT + x * (WIDTH - LEFT - RIGHT),
                HEIGHT - BOTTOM - y * (HEIGHT - TOP - BOTTOM))

    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" '
           f'height="{HEIGHT}" font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
           f'<text x="{LEFT}" y="22" font-size="15">{escape(args.title)}'
           '</text>']
    for i in range(math.floor((high_y - low_y) / args.step + 1e-9) + 1):
        psnr = low_y + i * args.step
        x, y = place(10 ** low_x, psnr)
        svg.append(f'<path d="M{x:.1f} {y:.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>'
                   f'<text x="{x - 8:.1f}" y="{y + 4:.1f}" '
                   f'text-anchor="end">{psnr:g}</text>')
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
               f'text-anchor="middle">{escape(args.x_label)}</text>'
               f'<text x="14" y="{TOP - 6}">{escape(args.y_label)}</text>')
    labels = []
    for (name, curve), color in zip(curves, COLORS * 3):
        at = [place(*p) for p in curve]
        path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in at)
        if not args.dots:
            svg.append(f'<path d="{path}" fill="none" stroke="{color}" '
                       'stroke-width="2"/>')
        for x, y in at if args.dots else at[-1:]:
            svg.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" '
                       f'fill="{color}"/>')
        x, y = at[-1]
        labels.append([y, x, name, curve[-1][1], color])
    # Labels stand at the right, apart from each other.
    labels.sort()
    bottom = TOP
    for y, x, name, psnr, color in labels:
        at = max(y, bottom)
        bottom = at + 16
        svg.append(f'<text x="{WIDTH - RIGHT + 10}" y="{at + 4:.1f}" '
                   f'fill="{color}">{escape(name)}'
                   f'{"" if args.dots else f" {psnr:.1f}"}</text>')
    svg.append("</svg>")
    with open(args.out, "w") as file:
        file.write("\n".join(svg) + "\n")


if __name__ == "__main__":
    main()
