#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Objects in whole runs, from the photographs on: how right, too fine, too coarse.

  bench/measure_objects.py PROGRAM DATA OUT [--scenes fox,desk,...]
      [--seeds 1,2,3] [--preset balanced] [--csv FILE]
      [--option bootstrap.granularity 0.5]

DATA is the folder of reference data (FREEGS_SHARED_DATA). Runs that are already
in OUT, one folder for each scene and seed, are gone on with, and phase 2 is
repeated where the program or an option has changed. Prints a table in Markdown:
means over the seeds, with the largest difference from the mean behind +-, and
below the means over the scenes.
"""
import argparse
import csv
import json
import subprocess
import sys
from pathlib import Path

from measure_semantics import said

REAL = {"fox": "fox", "desk": "real/desk", "fruit": "real/fruit",
        "kumamon": "real/kumamon", "flower": "real/flower"}
DRAWN = {"tabletop": "tabletop", "playroom": "playroom"}
METRICS = ["instance_miou", "best_level_miou", "click_miou", "pq", "instances_per_object",
           "objects_per_instance", "instances_seen", "crumbs", "uncovered",
           "text_miou", "box_miou", "holdout_psnr"]


def checked(command):
    done = subprocess.run(command, text=True, capture_output=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: {done.stderr[-2000:]}")


def measure(arguments, scene, truth, seed):
    """One run from the photographs to the figures of eval."""
    workspace = Path(arguments.out, f"{scene}_{seed}")
    options = [text for name, value in arguments.option
               for text in ("--" + name, value)]
    checked([arguments.program, "run", truth / "images", workspace,
             "--seed", seed, "--preset", arguments.preset,
             "--to", "bootstrap", *options])
    result = Path(arguments.out, f"{scene}_{seed}.json")
    checked([arguments.program, "eval", workspace, "--gt", truth,
             "--json", result])
    quality = json.loads(result.read_text())
    stage = json.loads(Path(workspace, "bootstrap/metrics.json").read_text())
    row = {"scene": scene, "seed": seed}
    row |= {name: quality.get(name) for name in METRICS}
    row["seconds"] = stage["seconds"]
    return row


def main():
    parser = argparse.ArgumentParser(
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("data", type=Path)
    parser.add_argument("out")
    parser.add_argument("--scenes", default=",".join(REAL | DRAWN))
    parser.add_argument("--seeds", default="1,2,3")
    parser.add_argument("--preset", default="balanced")
    parser.add_argument("--csv")
    parser.add_argument("--option", nargs=2, action="append", default=[],
                        metavar=("NAME", "VALUE"))
    arguments = parser.parse_args()
    scenes = arguments.scenes.split(",")
    unknown = set(scenes) - set(REAL | DRAWN)
    if unknown:
        parser.error(f"no such scene: {', '.join(sorted(unknown))}")

    Path(arguments.out).mkdir(parents=True, exist_ok=True)
    rows = []
    for scene in scenes:
        for seed in arguments.seeds.split(","):
            truth = arguments.data / (REAL | DRAWN)[scene]
            rows.append(measure(arguments, scene, truth, seed))
            print(rows[-1], file=sys.stderr, flush=True)

    names = [*METRICS, "seconds"]
    print("| scene | " + " | ".join(names) + " |")
    print("|" + "---|" * (len(names) + 1))
    for scene in scenes:
        same = [row for row in rows if row["scene"] == scene]
        print(f"| {scene} | " + " | ".join(
            said([row[name] for row in same]) for name in names) + " |")
    for title, group in (("mean of real", REAL), ("mean of drawn", DRAWN)):
        same = [row for row in rows if row["scene"] in group]
        if same:
            print(f"| {title} | " + " | ".join(
                said([row[name] for row in same]).split(" ")[0]
                for name in names) + " |")
    if arguments.csv:
        with open(arguments.csv, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
