#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""How well `run --within` keeps to its time, and what it makes of it.

  bench/keep_time.py PROGRAM OUT NAME:TIME:PHOTOS:TRUTH ...

PROGRAM is freegs_pipeline. OUT is a folder for the workspaces NAME, which are
made anew. TIME is as in `--within 2m`. TRUTH is a folder for `eval --gt`, or
empty. Nothing else should run on the machine. It prints a row of a table in
Markdown for each scene: the time that was asked for, what the run expected
before it began and when the cameras were known, how long it took, what it
trained, and the PSNR of the holdout photos and the mIoU of objects.
"""
import json
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

from peer_figures import argument_parser


def row(program, out, scene):
    """The cells of a scene's row."""
    name, asked, photos, truth = scene.split(":")
    workspace = out / name
    shutil.rmtree(workspace, ignore_errors=True)
    begin = time.monotonic()
    done = subprocess.run(
        [program, "run", photos, workspace, "--within", asked], text=True,
        errors="replace", stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    seconds = time.monotonic() - begin
    (out / f"{name}.log").write_text(done.stdout)
    if done.returncode != 0:
        sys.exit(f"{name}: exit code {done.returncode}, see {out / name}.log")

    def said(pattern):
        match = re.search(pattern, done.stdout)
        return match[1].strip() if match else "-"

    metrics = json.loads((workspace / "reconstruct/metrics.json").read_text())
    objects = "-"
    if truth:
        figures = out / f"{name}.json"
        subprocess.run([program, "eval", workspace, "--gt", truth, "--json",
                        figures], check=True, stdout=subprocess.DEVNULL)
        objects = f"{json.loads(figures.read_text())['instance_miou']:.2f}"
    planned = said(r"the cameras took .*?; (.*) are expected to end")
    # A training that was not ended early has all that was planned.
    done_all = planned.startswith(f"{metrics['iterations']:,} ")
    return [name, asked,
            said(r"expected to take ([^,\n]+)"),
            said(r"expected to end after ([^\n]+)"),
            f"{seconds:.0f} s",
            planned if done_all else f"{metrics['iterations']:,} of {planned}",
            f"{metrics['holdout_psnr']:.1f} dB", objects]


def main():
    parser = argument_parser(__doc__, "program", "out")
    parser.add_argument("scenes", nargs="+")
    arguments = parser.parse_args()
    out = Path(arguments.out)
    out.mkdir(parents=True, exist_ok=True)
    print("| scene | asked | expected before | expected with the cameras | took "
          "| training | new views, PSNR | objects, mIoU |\n" + "|---" * 8 + "|")
    for scene in arguments.scenes:
        cells = row(arguments.program, out, scene)
        print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
