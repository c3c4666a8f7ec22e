#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The short form of kill_resume.sh, part of all tests: two kills a stage.
#
#   tests/kill_resume_test.sh BIN
set -euo pipefail
unset CDPATH  # It would lead cd to other folders.

bin=$(realpath "$1")
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$bin/freegs_make_scene" --out "$folder/scene" --views 12 --width 240 \
  --height 180 >/dev/null 2>&1
WITHIN=2 "$here/kill_resume.sh" "$bin/freegs_pipeline" "$folder/scene/images" \
  "$folder/runs" 2 --reconstruct.iterations 300 --reconstruct.budget 2000 \
  --threads 2 --general.checkpoint_interval 1 ||
  { tail -n 20 "$folder/runs/runs.log"; exit 1; }
