#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Draws quality against time as an SVG, seconds on a log scale.

    bench/plot_curves.py OUT.svg TITLE NAME=CURVE.csv ...

CURVE.csv has the columns seconds and holdout_psnr, as freegs_training_benchmark
curve prints them, or those that --x and --y name; a file of one row is drawn as
a point. What lies below --low is drawn at the lower edge. With --label, each
row is a dot beside the text of that column; rows without a number in --y are
named at the right.
"""
import argparse
import csv
import math
from xml.sax.saxutils import escape

WIDTH, HEIGHT = 760, 440
LEFT, RIGHT, TOP, BOTTOM = 56, 170, 40, 48
COLORS = ["#1b6ca8", "#2a9d5c", "#8e44ad", "#c0392b", "#d98200", "#555555"]


def read_curve(path, x, y, label=None):
    """(x, y, label) of each row, and labels of rows without a number in y."""
    with open(path, newline="") as file:
        lines = [l for l in file if "," in l]
    table = list(csv.DictReader(lines))
    rows = [(float(r[x]), float(r[y]), r[label] if label else "")
            for r in table if r[y]]
    return ([row for row in rows if row[0] > 0],
            [r[label] for r in table if label and not r[y]])


def overlap(a, b):
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def place_labels(dots):
    """Where texts go: (x, baseline, whether a line to the dot is needed).

    dots: (x, y, text). Beside its own dot, and free of other dots and texts
    where that is possible.
    """
    taken = [(x - 5, y - 5, x + 5, y + 5) for x, y, _ in dots]
    places = []
    for x, y, text in dots:
        width = 6.4 * len(text)
        near = [(x + 8, y + 4), (x - 8 - width, y + 4),
                (x - width / 2, y - 8), (x - width / 2, y + 17)]
        far = [(x + side, y + 4 + drop) for drop in
               (-18, 18, -32, 32, -46, 46, -60, 60, -74, 74)
               for side in (10, -10 - width)]
        for at in near + far:
            box = (at[0], at[1] - 11, at[0] + width, at[1] + 3)
            if (box[0] > LEFT and box[2] < WIDTH - RIGHT + 8 and
                    box[1] > TOP - 4 and box[3] < HEIGHT - BOTTOM and
                    not any(overlap(box, other) for other in taken)):
                break
        else:
            at, box = near[0], (x, y, x, y)
        taken.append(box)
        places.append((*at, at in far))
    return places


def ticks(low, high, digits=(1, 2, 5)):
    """Round numbers between two powers of ten."""
    return [digit * 10.0 ** power
            for power in range(math.floor(low), math.ceil(high) + 1)
            for digit in digits
            if low - 1e-9 <= math.log10(digit * 10.0 ** power) <= high + 1e-9]


class Axes:
    """Where values stand in the picture; seconds, and with log_y both, on a log
    scale."""

    def __init__(self, points, args):
        self.log_y = args.log_y
        self.low_x = math.log10(min(s for s, _ in points))
        self.high_x = math.log10(max(s for s, _ in points)) + 0.03
        if args.label:
            self.low_x -= 0.05
            self.high_x += 0.02
        values = [p for _, p in points]
        self.low_y, self.high_y = args.low, args.high
        if self.log_y:
            self.low_y = math.log10(args.low or min(values) / 1.3)
            self.high_y = math.log10(args.high or max(values) * 1.3)
        if self.low_y is None:
            self.low_y = math.floor(max(min(values), 14))
        if self.high_y is None:
            self.high_y = math.ceil(max(values))

    def place(self, seconds, psnr):
        if self.log_y:
            psnr = math.log10(psnr)
        x = (math.log10(seconds) - self.low_x) / (self.high_x - self.low_x)
        y = (max(psnr, self.low_y) - self.low_y) / (self.high_y - self.low_y)
        return (LEFT + x * (WIDTH - LEFT - RIGHT),
                HEIGHT - BOTTOM - y * (HEIGHT - TOP - BOTTOM))

    def draw(self, args):
        if self.log_y:
            grid = ticks(self.low_y, self.high_y)
            if len(grid) < 3:
                grid = ticks(self.low_y, self.high_y, range(1, 10))
            lowest = 10 ** self.low_y
        else:
            count = math.floor((self.high_y - self.low_y) / args.step + 1e-9)
            grid = [self.low_y + i * args.step for i in range(count + 1)]
            lowest = self.low_y
        svg = []
        for psnr in grid:
            x, y = self.place(10 ** self.low_x, psnr)
            svg.append(
                f'<path d="M{x:.1f} {y:.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>'
                f'<text x="{x - 8:.1f}" y="{y + 4:.1f}" '
                f'text-anchor="end">{psnr:g}</text>')
        for seconds in ticks(self.low_x, self.high_x):
            x, y = self.place(seconds, lowest)
            svg.append(f'<path d="M{x:.1f} {TOP}V{y:.1f}" stroke="#eee"/>'
                       f'<text x="{x:.1f}" y="{y + 18:.1f}" '
                       f'text-anchor="middle">{seconds:g}</text>')
        svg.append(
            f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 10}" '
            f'text-anchor="middle">{escape(args.x_label)}</text>'
            f'<text x="14" y="{TOP - 6}">{escape(args.y_label)}</text>')
        return svg


def draw_labels(dots):
    """The texts of dots (x, y, text, colour)."""
    svg = []
    for (x, y, text, color), (at_x, at_y, line) in zip(
            dots, place_labels([dot[:3] for dot in dots])):
        if line:
            end = at_x if at_x > x else at_x + 6.4 * len(text)
            svg.append(f'<path d="M{x:.1f} {y:.1f}L{end:.1f} {at_y - 4:.1f}" '
                       f'stroke="{color}" stroke-width="0.6"/>')
        svg.append(f'<text x="{at_x:.1f}" y="{at_y:.1f}" fill="{color}">'
                   f'{escape(text)}</text>')
    return svg


def draw_right(texts):
    """Texts (y, x, text, colour) at the right, apart from each other."""
    svg = []
    bottom = TOP
    for y, _, text, color in sorted(texts):
        at = max(y, bottom)
        bottom = at + 16
        svg.append(f'<text x="{WIDTH - RIGHT + 10}" y="{at + 4:.1f}" '
                   f'fill="{color}">{escape(text)}</text>')
    return svg


def parse_arguments():
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
    parser.add_argument("--label",
                        help="column; a dot per row instead of a line")
    parser.add_argument("--log-y", action="store_true",
                        help="a log scale for y too; --step is not used")
    return parser.parse_args()


def main():
    args = parse_arguments()
    curves, missing = [], []
    for argument in args.curves:
        name, path = argument.split("=", 1)
        rows, without = read_curve(path, args.x, args.y, args.label)
        missing += [f"{name}: {text}" if len(args.curves) > 1 else text
                    for text in without]
        if args.log_y:
            rows = [row for row in rows if row[1] > 0]
        if args.label:
            rows.sort()
        if not rows:
            raise SystemExit(f"{path}: no row has both {args.x} and {args.y}")
        curves.append((name, rows))
    axes = Axes([row[:2] for _, rows in curves for row in rows], args)
    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" '
           f'height="{HEIGHT}" font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
           f'<text x="{LEFT}" y="{17 if args.label else 22}" '
           f'font-size="15">{escape(args.title)}</text>', *axes.draw(args)]
    right, dots = [], []
    for (name, rows), color in zip(curves, COLORS * 3):
        at = [axes.place(x, y) for x, y, _ in rows]
        path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in at)
        if not args.label:
            svg.append(f'<path d="{path}" fill="none" stroke="{color}" '
                       'stroke-width="2"/>')
        for x, y in at if args.label else at[-1:]:
            svg.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" '
                       f'fill="{color}"/>')
        dots += [(*p, row[2], color) for p, row in zip(at, rows)]
        x, y = at[-1]
        right.append((y, x, name if args.label else f"{name} {rows[-1][1]:.1f}",
                      color))
    if args.label:
        svg += draw_labels(dots)
        # The files' names, then what is not in the chart.
        right = [(TOP + 8, i, text, color) for i, (_, _, text, color) in
                 enumerate(right if len(right) > 1 else [])]
        if missing:
            right += [(TOP + 9, i, text, "#777") for i, text in
                      enumerate(["without a result:", *missing])]
    svg += draw_right(right) + ["</svg>"]
    with open(args.out, "w") as file:
        file.write("\n".join(svg) + "\n")


if __name__ == "__main__":
    main()
