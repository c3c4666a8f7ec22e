#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Each preset several times: seconds, holdout PSNR and SSIM, Gaussians.

  bench/measure_presets.py BENCHMARK WORKSPACE [--rounds 3] [--out FOLDER]
      [--max-image-size 480] [--presets fast,balanced,quality]

BENCHMARK is freegs_training_benchmark. Medians, then least to most. The last
round's curves are left in FOLDER, for plot_curves.py. Nothing else should run on
the machine meanwhile.
"""
import argparse
import csv
import os
import statistics
import subprocess


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("benchmark")
    parser.add_argument("workspace")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--out")
    parser.add_argument("--max-image-size", default="480")
    parser.add_argument("--presets", default="fast,balanced,quality")
    args = parser.parse_args()
    ends = {}
    for _ in range(args.rounds):
        for preset in args.presets.split(","):
            text = subprocess.run(
                [args.benchmark, "curve", args.workspace, "--preset", preset,
                 "--max-image-size", args.max_image_size, "--every", "250",
                 "--set", "reconstruct.exposure=off"],
                check=True, text=True, stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL).stdout
            if args.out:
                os.makedirs(args.out, exist_ok=True)
                with open(os.path.join(args.out, preset + ".csv"), "w",
                          encoding="utf-8") as file:
                    file.write(text)
            end = list(csv.DictReader(text.splitlines()))[-1]
            ends.setdefault(preset, []).append(end)
            print(preset, ", ".join(f"{k} {v}" for k, v in end.items()),
                  flush=True)
    for preset, rows in ends.items():
        print(preset + ":")
        for name in rows[0]:
            values = [float(row[name]) for row in rows]
            print(f"  {name} {statistics.median(values):.5g} "
                  f"({min(values):.5g} to {max(values):.5g})")


if __name__ == "__main__":
    main()
