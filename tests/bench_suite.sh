#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# `bench` as a user meets it: a suite that is killed goes on with what is done,
# and ends with the same figures; failed cells are kept; a baseline tells what
# moved.
#
#   tests/bench_suite.sh BIN
set -euo pipefail

bin=$(realpath "$1")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

fail() {
  echo "bench_suite.sh: $*" >&2
  exit 1
}

cat >"$folder/suite.ini" <<'SUITE'
[suite]
title = Killed
seeds = 1 2
to = reconstruct
preset = fast
threads = 1
sfm.import = ${scene}/gt/transforms.json
sfm.random_points = 10000
reconstruct.exposure = off
[scene table]
draw = --views 12 --test_views 2 --width 160 --height 120
[grid training]
reconstruct.iterations = 100 300
[grid broken]
sfm.import = ${scene}/gt/missing.json
[grid disturbed]
seeds = 1
disturb = blur:1 jitter:1
reconstruct.iterations = 100
[chart speed]
x = reconstruct.cpu_seconds
y = holdout_psnr
SUITE

# What does not depend on the time it took: accuracies and sizes.
figures() {
  columns=$(head -1 "$1" | tr ',' '\n' | tr -d '\r' |
    grep -nE '^(scene|grid|seed|status|exit_code|holdout_psnr|psnr|scene_bytes)$' |
    cut -d: -f1 | paste -sd,)
  cut -d, -f"$columns" "$1"
}

"$bin/freegs_pipeline" bench "$folder/suite.ini" --out "$folder/whole" \
  >"$folder/whole.log" 2>&1 || { cat "$folder/whole.log"; fail "a whole bench"; }
grep -q 'failed in sfm with exit code 3' "$folder/whole.log" ||
  fail "the broken cells are not told of"
[ "$(grep -c '"status": "done"' "$folder/whole/results.json")" = 6 ] ||
  fail "six cells should be done"
[ "$(grep -c '"status": "failed"' "$folder/whole/results.json")" = 2 ] ||
  fail "two cells should have failed"

# Killed at three moments, each time with what hangs on it.
for cells in 1 2 3; do
  "$bin/freegs_pipeline" bench "$folder/suite.ini" --out "$folder/killed" \
    >>"$folder/killed.log" 2>&1 &
  pid=$!
  for _ in $(seq 4000); do
    [ "$(grep -cs '"status": "done"' "$folder/killed/results.json" || true)" \
      -ge "$cells" ] 2>/dev/null && break
    kill -0 $pid 2>/dev/null || break
    sleep 0.05
  done
  sleep 0.3
  kill -9 $pid 2>/dev/null || true
  wait $pid 2>/dev/null || true
  [ "$cells" = 1 ] &&
    first=$(stat -c %n.%Y.%i "$folder"/killed/store/ingest_*/outcome.json)
done
"$bin/freegs_pipeline" bench "$folder/suite.ini" --out "$folder/killed" \
  --jobs 2 >>"$folder/killed.log" 2>&1 ||
  { cat "$folder/killed.log"; fail "a killed bench does not go on"; }
# The disturbed photographs have an ingest of their own, which came later.
stat -c %n.%Y.%i "$folder"/killed/store/ingest_*/outcome.json | grep -qxF "$first" ||
  fail "what was done before the kill was done again"
diff <(figures "$folder/whole/results.csv") <(figures "$folder/killed/results.csv") ||
  fail "a killed bench ends with other figures"

# A cell is a workspace that other commands read.
cell=$(find "$folder/whole/cells" -maxdepth 1 -name 'table_training_1_*' | head -1)
"$bin/freegs_pipeline" status "$cell" | grep -q 'reconstruct.*done' ||
  fail "a cell is no workspace"

# Against a baseline: as before, and then not.
baseline() {
  "$bin/freegs_pipeline" bench "$folder/suite.ini" --out "$folder/whole" \
    --baseline "$folder/baseline.json" "$@" >"$folder/baseline.log" 2>&1
}
baseline --write-baseline || fail "no baseline"
baseline || { cat "$folder/baseline.log"; fail "moved without a change"; }
sed -i 's/"scene_bytes": [0-9][0-9.]*/"scene_bytes": 1000.0/' "$folder/baseline.json"
code=0
baseline || code=$?
[ "$code" = 4 ] || fail "a moved figure ends with $code"
grep -q 'moved: table, grid training.*scene_bytes 1000 ->' "$folder/baseline.log" ||
  fail "what moved is not named"

# Failures alone do not become a baseline.
cat >"$folder/broken.ini" <<SUITE
[suite]
to = sfm
sfm.import = missing.json
[scene table]
images = $(echo "$folder"/whole/scenes/table_*/images)
SUITE
code=0
"$bin/freegs_pipeline" bench "$folder/broken.ini" --out "$folder/broken" \
  --baseline "$folder/broken.json" --write-baseline >"$folder/log" 2>&1 || code=$?
[ "$code" = 4 ] || { cat "$folder/log"; fail "a baseline of failures ends with $code"; }
[ ! -e "$folder/broken.json" ] || fail "failures became a baseline"

# Wrong usage and hostile suites.
expect() {
  wanted=$1
  shift
  code=0
  "$bin/freegs_pipeline" bench "$@" >"$folder/log" 2>&1 || code=$?
  [ "$code" = "$wanted" ] || { cat "$folder/log"; fail "$* ends with $code"; }
}
expect 2 "$folder/suite.ini"
expect 3 "$folder/none.ini" --out "$folder/x"
expect 3 "$folder/suite.ini" --out "$folder"
head -c 4000 /dev/urandom >"$folder/noise.ini"
expect 2 "$folder/noise.ini" --out "$folder/x"
expect 0 "$folder/suite.ini" --list
[ "$(wc -l <"$folder/log")" = 8 ] || fail "--list lists eight cells"
echo "bench_suite.sh: all is well"
