#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Mini-Splatting against the densification of 3DGS at the same budget of
# Gaussians, three seeds each: prints method, scene, seed, holdout PSNR and SSIM,
# Gaussians and CPU seconds, then mean and spread.
#
#   bench/compare_densification.sh PIPELINE WORKSPACE ...
#
# Each WORKSPACE has been run up to undistort; it is copied, not changed.
set -euo pipefail

pipeline=${1:?usage: bench/compare_densification.sh PIPELINE WORKSPACE ...}
shift
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

for workspace in "$@"; do
  for method in gradient mini_splatting; do
    for seed in 1 2 3; do
      rm -rf "$scratch/run"
      cp -r "$workspace" "$scratch/run"
      rm -rf "$scratch/run/reconstruct"
      "$pipeline" stage reconstruct "$scratch/run" --general.seed "$seed" \
        --reconstruct.densification "$method" --reconstruct.budget 40000 \
        --reconstruct.iterations 2000 --reconstruct.max_image_size 480 \
        --reconstruct.densify_gradient 1e-4 \
        >"$scratch/log" 2>&1 || { cat "$scratch/log" >&2; exit 1; }
      python3 - "$workspace" "$method" "$seed" \
        "$scratch/run/reconstruct/metrics.json" <<'PYTHON' | tee -a "$scratch/rows"
import json, os, sys
workspace, method, seed, path = sys.argv[1:]
m = json.load(open(path))
print(os.path.basename(workspace.rstrip("/")), method, seed,
      f"{m['holdout_psnr']:.3f}", f"{m['holdout_ssim']:.4f}",
      m["num_gaussians"], f"{m['cpu_seconds']:.1f}")
PYTHON
    done
  done
done
python3 - "$scratch/rows" <<'PYTHON'
import statistics, sys
groups = {}
for line in open(sys.argv[1]):
    scene, method, _, psnr, ssim, gaussians, _ = line.split()
    groups.setdefault((scene, method), []).append(
        (float(psnr), float(ssim), int(gaussians)))
for (scene, method), rows in groups.items():
    psnr = [r[0] for r in rows]
    print(f"{scene:10} {method:15} PSNR {statistics.mean(psnr):.2f} "
          f"({min(psnr):.2f} to {max(psnr):.2f})  "
          f"SSIM {statistics.mean(r[1] for r in rows):.4f}  "
          f"Gaussians {statistics.mean(r[2] for r in rows):.0f}")
PYTHON
