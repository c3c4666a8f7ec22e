#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Phase 2 in several ways on scenes whose truth is known: how right, how long.

  bench/measure_semantics.py PROGRAM --scene WORKSPACE TRUTH [--scene ...]
      [--ways lift,paper,...] [--seeds 1,2,3] [--csv FILE]
      [--option bootstrap.semantic_weight 0.4]

PROGRAM is freegs_pipeline; a WORKSPACE is reconstructed (its bootstrap/ is not
touched), TRUTH is a folder for eval --gt. Every seed is one of phase 2 only,
unless WORKSPACE holds {seed}, which is replaced. Prints a table in Markdown:
means over the seeds, and the largest difference from the mean behind +-.
Seconds and memory are those of stage bootstrap; nothing else should run.
"""
import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

# Options of stage bootstrap. The ablations are the paper's (its table 5), each
# of the trained field.
WAYS = {
    "geometry": ["--bootstrap.mode", "geometry"],
    "lift": ["--bootstrap.mode", "lift"],
    "paper": ["--bootstrap.mode", "paper"],
    "no L_C": ["--bootstrap.mode", "paper",
               "--bootstrap.contrastive_weight", "0"],
    "no F_ins": ["--bootstrap.mode", "paper",
                 "--bootstrap.instance_weight", "0"],
    "no smoothing": ["--bootstrap.mode", "paper",
                     "--bootstrap.smoothing_weight", "0"],
    "random start": ["--bootstrap.mode", "paper",
                     "--bootstrap.random_start", "true"],
    "union space": ["--bootstrap.mode", "lift",
                    "--bootstrap.clustering", "union"],
    # Gaussians answer to words, each for itself.
    "places alone": ["--bootstrap.mode", "lift"],
}
EVAL_OPTIONS = {"places alone": ["--text-from", "gaussians"]}
METRICS = ["instance_miou", "click_miou", "text_miou", "text_mbiou",
           "box_miou", "box_recall25", "box_recall50", "view_consistency",
           "pq", "instances_per_object", "objects_per_instance", "crumbs"]


def borrowed(workspace, folder):
    """A workspace that shares all but phase 2 with another."""
    for name in ("ingest", "sfm", "undistort", "reconstruct"):
        os.symlink(os.path.abspath(os.path.join(workspace, name)),
                   os.path.join(folder, name))
    return folder


def measure(program, workspace, truth, way, seed, extra):
    with tempfile.TemporaryDirectory() as folder:
        borrowed(workspace.replace("{seed}", seed), folder)
        command = [program, "stage", "bootstrap", folder, "--seed", seed,
                   *WAYS[way], *extra]
        done = subprocess.run(command, text=True, capture_output=True,
                              check=False)
        if done.returncode != 0:
            sys.exit(f"{' '.join(command)}: {done.stderr[-2000:]}")
        result = os.path.join(folder, "eval.json")
        subprocess.run([program, "eval", folder, "--gt", truth,
                        "--json", result, *EVAL_OPTIONS.get(way, [])],
                       check=True, capture_output=True)
        quality = json.loads(Path(result).read_text())
        stage = json.loads(
            Path(folder, "bootstrap", "metrics.json").read_text())
    row = {name: quality.get(name) for name in METRICS}
    row["seconds"] = stage["seconds"]
    row["cpu_seconds"] = stage["cpu_seconds"]
    row["peak_gb"] = stage["peak_memory_bytes"] / 1e9
    row["instances"] = stage["num_instances"]
    row["dim"] = stage.get("feature_dim")
    row["iterations"] = stage.get("iterations")
    return row


def said(values):
    """Mean and spread of what was measured."""
    values = [value for value in values if value is not None]
    if not values:
        return ""
    mean = sum(values) / len(values)
    spread = max(abs(value - mean) for value in values)
    digits = 3 if mean < 2 else 1 if mean < 100 else 0
    text = f"{mean:.{digits}f}"
    return text + (f" +-{spread:.{digits}f}" if len(values) > 1 else "")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--scene", nargs=2, action="append", required=True,
                        metavar=("WORKSPACE", "TRUTH"))
    parser.add_argument("--ways", default=",".join(WAYS))
    parser.add_argument("--seeds", default="1,2,3")
    parser.add_argument("--csv")
    parser.add_argument("--option", nargs=2, action="append", default=[],
                        metavar=("NAME", "VALUE"),
                        help="further options of the stage, such as "
                        "bootstrap.semantic_weight 0.4")
    arguments = parser.parse_args()
    extra = [text for name, value in arguments.option
             for text in ("--" + name, value)]
    rows = []
    for way in arguments.ways.split(","):
        for workspace, truth in arguments.scene:
            for seed in arguments.seeds.split(","):
                row = {"way": way, "scene": Path(truth).name, "seed": seed}
                row |= measure(arguments.program, workspace, truth, way, seed,
                               extra)
                rows.append(row)
                print(row, file=sys.stderr, flush=True)
    names = [name for name in rows[0] if name not in ("way", "scene", "seed")]
    print("| way | scene | " + " | ".join(names) + " |")
    print("|" + "---|" * (len(names) + 2))
    for way in arguments.ways.split(","):
        for _, truth in arguments.scene:
            scene = Path(truth).name
            same = [row for row in rows
                    if row["way"] == way and row["scene"] == scene]
            print(f"| {way} | {scene} | " + " | ".join(
                said([row[name] for row in same]) for name in names) + " |")
    if arguments.csv:
        with open(arguments.csv, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
