#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Clustering here against scikit-learn-contrib/hdbscan, in turn.

  bench/compare_hdbscan.py BENCHMARK FOLDER [--sets a20 b60] [--rounds 3]
                           [--jobs 2]

BENCHMARK is freegs_hdbscan_benchmark. FOLDER holds points.f32 (raw floats) and
per set result_SET.json: params, mst_weight, d and tie_spread of the library's
labels. The library must be importable (PYTHONPATH); it runs exactly
(approx_min_span_tree=False), fit_predict alone is timed. CPU seconds are those
of the process and all its workers. Checks that both partitions agree as far as
ties let them and prints every figure, medians and ratios. Nothing else should
run on the machine meanwhile.
"""
import csv
import json
import os
import resource
import subprocess
import sys
import tempfile
import time

import numpy as np

from peer_figures import Figures, add_rounds, argument_parser, timed


def peer(points, dim, size, jobs, out):
    """Runs the library; prints wall seconds, and CPU seconds before the fit."""
    import hdbscan
    data = np.fromfile(points, "<f4").reshape(-1, dim).astype(np.float64)
    clusterer = hdbscan.HDBSCAN(min_cluster_size=size, min_samples=size,
                                approx_min_span_tree=False,
                                core_dist_n_jobs=jobs)
    usage = resource.getrusage(resource.RUSAGE_SELF)
    begin = time.monotonic()
    labels = clusterer.fit_predict(data)
    wall = time.monotonic() - begin
    labels.astype("<i4").tofile(out)
    print(wall, usage.ru_utime + usage.ru_stime)


def run_peer(points, dim, size, jobs, out):
    _, cpu, text = timed(
        [sys.executable, __file__, "--peer", points, str(dim), str(size),
         str(jobs), out])
    wall, cpu_before = map(float, text.split())
    return wall, cpu - cpu_before


def run_ours(benchmark, points, dim, size, threads, out):
    text = subprocess.run(
        [benchmark, points, str(dim), "--size", str(size), "--threads",
         str(threads), "--labels", out], check=True, text=True,
        stdout=subprocess.PIPE).stdout
    row = next(csv.DictReader(text.splitlines()))
    return (float(row["seconds"]), float(row["cpu_seconds"]),
            float(row["mst_weight"]))


def pairs(counts):
    return float((counts * (counts - 1.0) / 2).sum())


def adjusted_rand_index(a, b):
    a = np.unique(a, return_inverse=True)[1].astype(np.int64)
    b = np.unique(b, return_inverse=True)[1].astype(np.int64)
    cells = np.unique(a * (b.max() + 1) + b, return_counts=True)[1]
    in_a, in_b = pairs(np.bincount(a)), pairs(np.bincount(b))
    expected = in_a * in_b / (len(a) * (len(a) - 1.0) / 2)
    largest = (in_a + in_b) / 2
    if largest == expected:
        return 1.0
    return (pairs(cells) - expected) / (largest - expected)


def compare(args, name, scratch):
    points = os.path.join(args.folder, "points.f32")
    with open(os.path.join(args.folder, f"result_{name}.json")) as file:
        reference = json.load(file)
    params = reference["params"]
    size, dim = params["min_samples"], reference["d"]
    if (params["min_cluster_size"] != size or
            params["cluster_selection_epsilon"] or params["max_cluster_size"] or
            params["cluster_selection_method"] != "eom"):
        sys.exit(f"{name}: only sets of one size and no other option")
    figures = Figures(name + " ")
    note = figures.note
    theirs = os.path.join(scratch, "theirs.i32")
    ours = os.path.join(scratch, "ours.i32")
    for _ in range(args.rounds):
        wall, cpu = run_peer(points, dim, size, args.jobs, theirs)
        note("hdbscan, wall seconds", wall)
        note("hdbscan, CPU seconds", cpu)
        our_wall, our_cpu, weight = run_ours(args.benchmark, points, dim, size,
                                             args.jobs, ours)
        note("ours, wall seconds", our_wall)
        note("ours, CPU seconds", our_cpu)
        note("times faster, wall", wall / our_wall)
        note("times less CPU", cpu / our_cpu)
        error = abs(weight / reference["mst_weight"] - 1)
        note("relative error of the tree's weight", error)
        ari = adjusted_rand_index(np.fromfile(theirs, "<i4"),
                                  np.fromfile(ours, "<i4"))
        note("Rand index of the partitions", ari)
        least = reference["tie_spread"]["min_ari"] - 0.005
        if ari < least or error > 1e-9:
            sys.exit(f"{name}: the results differ (least index {least})")
    figures.print_medians(
        f"{name}, medians of {args.rounds} rounds, {args.jobs} threads")


def main():
    if sys.argv[1:2] == ["--peer"]:
        points, dim, size, jobs, out = sys.argv[2:]
        return peer(points, int(dim), int(size), int(jobs), out)
    parser = argument_parser(__doc__, "benchmark", "folder")
    parser.add_argument("--sets", nargs="+", default=["a20", "b60"])
    add_rounds(parser, 3)
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        for name in args.sets:
            compare(args, name, scratch)


if __name__ == "__main__":
    main()
