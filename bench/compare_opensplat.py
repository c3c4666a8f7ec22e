#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Training here against OpenSplat's CPU build, from the same start.

  bench/compare_opensplat.py BENCHMARK WORKSPACE NEW [OLD] [--rounds 3] [--avx2]

BENCHMARK is freegs_training_benchmark; NEW and OLD are binaries of OpenSplat
(GPU_RUNTIME=CPU), OLD of version 1.1.5. Each round runs one after the other:
time per step (theirs: 100 steps less a run of one), 1000 steps of theirs with
the holdout PSNR of the result, and the curve of ours. Prints every figure, then
medians. Nothing else should run on the machine meanwhile. With --avx2 both sides
use no instructions beyond AVX2.
"""
import csv
import os
import tempfile

from peer_figures import Figures, add_rounds, argument_parser, timed

TO_PSNR = ["--max-image-size", "480", "--set", "reconstruct.iterations=1000",
           "--set", "reconstruct.budget=15000", "--set", "reconstruct.exposure=off",
           "--every", "25"]
OLD_BACKGROUND = ["--background", "0.613,0.0101,0.3984"]  # Its own.


# What keeps the libraries of PyTorch to AVX2.
THEIR_AVX2 = {"ATEN_CPU_CAPABILITY": "avx2", "ONEDNN_MAX_CPU_ISA": "AVX2",
              "OPENBLAS_CORETYPE": "Haswell"}


def opensplat(binary, project, folder, steps, old):
    os.makedirs(folder, exist_ok=True)
    ply = os.path.join(folder, "splat.ply")
    extra = ["--keep-crs"] if old else ["--no-masks"]
    wall, cpu, _ = timed([binary, project, "-n", str(steps), "-d", "4",
                          "--num-downscales", "0", "-o", ply] + extra)
    return wall, cpu, ply


def rows(text):
    """The lines of a CSV as dictionaries; text stays text."""
    return list(csv.DictReader(text.splitlines()))


def our_curve(benchmark, workspace, simd):
    _, _, text = timed([benchmark, "curve", workspace] + TO_PSNR + simd)
    return [{"seconds": float(row["seconds"]),
             "psnr": float(row["holdout_psnr"])} for row in rows(text)]


def when(curve, psnr):
    """Seconds until the PSNR is reached first, and for good."""
    first = next((r["seconds"] for r in curve if r["psnr"] >= psnr),
                 float("nan"))
    good = float("nan")
    for row in reversed(curve):
        if row["psnr"] < psnr:
            break
        good = row["seconds"]
    return first, good


def main():
    parser = argument_parser(__doc__, "benchmark", "workspace", "new")
    parser.add_argument("old", nargs="?")
    parser.add_argument("--avx2", action="store_true",
                        help="no instructions beyond AVX2, on both sides")
    add_rounds(parser, 3)
    args = parser.parse_args()
    simd = ["--simd", "AVX2"] if args.avx2 else []
    if args.avx2:
        os.environ.update(THEIR_AVX2)
    peers = [("new", args.new, False)]
    if args.old:
        peers.append(("old", args.old, True))
    figures = Figures()
    note = figures.note
    with tempfile.TemporaryDirectory() as scratch:
        project = os.path.join(scratch, "project")
        timed([args.benchmark, "export", args.workspace, project])
        for _ in range(args.rounds):
            curve = our_curve(args.benchmark, args.workspace, simd)
            note("ours, seconds of 1000 steps", curve[-1]["seconds"])
            note("ours, PSNR after 1000 steps", curve[-1]["psnr"])
            for name, binary, old in peers:
                folder = os.path.join(scratch, name)
                wall1, cpu1, _ = opensplat(binary, project, folder, 1, old)
                wall, cpu, _ = opensplat(binary, project, folder, 101, old)
                note(f"{name}, wall ms a step", 10 * (wall - wall1))
                note(f"{name}, CPU ms a step", 10 * (cpu - cpu1))
                wall, cpu, ply = opensplat(binary, project, folder, 1000, old)
                note(f"{name}, seconds of 1000 steps", wall)
                note(f"{name}, CPU seconds of 1000 steps", cpu)
                evaluate = [args.benchmark, "evaluate", args.workspace, ply]
                _, _, text = timed(evaluate + (OLD_BACKGROUND if old else []))
                psnr = float(rows(text)[-1]["holdout_psnr"])
                note(f"{name}, PSNR after 1000 steps", psnr)
                first, good = when(curve, psnr)
                note(f"ours, seconds to the PSNR of {name}, first", first)
                note(f"ours, seconds to the PSNR of {name}, for good", good)
                note(f"times sooner than {name}, first", wall / first)
                note(f"times sooner than {name}, for good", wall / good)
            for threads in ["1", "2"]:
                _, _, text = timed([args.benchmark, "steps", args.workspace,
                                    "--threads", threads] + simd)
                print(f"ours, {threads} threads:\n{text}", flush=True)
    figures.print_medians("medians")


if __name__ == "__main__":
    main()
