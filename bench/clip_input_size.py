#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Which image size is worth its cost for features of places.

  bench/clip_input_size.py PROGRAM BENCHMARK MODEL
      --scene WORKSPACE TRUTH [--scene ...] --out FOLDER

PROGRAM is freegs_pipeline, BENCHMARK freegs_clip_benchmark. MODEL is a folder
with several dense networks (--dense-size of scripts/export_clip.py or
scripts/train_small_clip.py). For each of its sizes: milliseconds of one image,
and text mIoU of phase 2 (mode lift) when words are compared with the lifted
features of each Gaussian alone (eval --text-from gaussians), on reconstructed
WORKSPACEs with known TRUTH as for bench/measure_semantics.py. Writes one
SCENE.csv for each; nothing else should run. A chart:

  bench/plot_curves.py OUT.svg TITLE SCENE=FOLDER/SCENE.csv ... --label size
      --x milliseconds --y text_miou --x-label "milliseconds per photograph"
      --y-label "text mIoU of places alone" --low 0.2 --high 1 --step 0.2
"""
import argparse
import csv
import json
import os
import subprocess
from pathlib import Path

from measure_semantics import measure


def times(benchmark, model):
    """Median milliseconds of a photograph by image size."""
    done = subprocess.run(
        [benchmark, "--benchmark_filter=BM_EncodeDense",
         "--benchmark_repetitions=3", "--benchmark_format=json"],
        env={**os.environ, "FREEGS_CLIP_MODEL": model}, text=True,
        capture_output=True, check=True)
    return {int(row["label"].split()[0]): row["real_time"]
            for row in json.loads(done.stdout)["benchmarks"]
            if row.get("aggregate_name") == "median"}


def main():
    parser = argparse.ArgumentParser(
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("benchmark")
    parser.add_argument("model")
    parser.add_argument("--scene", nargs=2, action="append", required=True,
                        metavar=("WORKSPACE", "TRUTH"))
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    milliseconds = times(arguments.benchmark, arguments.model)
    arguments.out.mkdir(parents=True, exist_ok=True)
    for workspace, truth in arguments.scene:
        path = arguments.out / f"{Path(truth).name}.csv"
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(["size", "milliseconds", "text_miou",
                             "text_mbiou", "stage_seconds"])
            for size in sorted(milliseconds):
                row = measure(arguments.program, workspace, truth,
                              "places alone", "1",
                              ["--bootstrap.model", arguments.model,
                               "--bootstrap.dense_size", str(size)])
                line = [size, f"{milliseconds[size]:.2f}", row["text_miou"],
                        row["text_mbiou"], row["seconds"]]
                print(path.stem, *line, flush=True)
                writer.writerow(line)


if __name__ == "__main__":
    main()
