#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Builds the fuzz targets of all readers (tests/fuzz, needs clang-14) and runs each
# of them. Prints one line per target, and fails if one of them finds something.
#
#   scripts/fuzz.sh [SECONDS [TARGET ...]]     e.g. 600 splat_Ply sfm_Transforms
#
# SECONDS is the time per target (default: 60). Without TARGET all run. The variable
# BUILD names the build folder (default: build-fuzz). It keeps:
#   corpus/TARGET     the inputs that reach new code. A later run goes on from them.
#   findings/TARGET-* the inputs that end the program
#   findings/TARGET.log   why they end it
# This shows a finding again:
#
#   build-fuzz/fuzz/TARGET build-fuzz/findings/TARGET-crash-...
set -euo pipefail
unset CDPATH  # It would lead cd to other folders.
cd "$(dirname "${BASH_SOURCE[0]}")/.."

seconds=${1:-60}
shift || true
build=${BUILD:-build-fuzz}
scripts/configure.sh "$build" --preset fuzz >/dev/null
cmake --build "$build" --parallel "$(nproc)" --target freegs_fuzz

build=$(cd "$build" && pwd)
mkdir -p "$build/findings"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
grep '^leak:' tests/sanitizer_suppressions.txt >"$scratch/leaks.txt" || true
export LSAN_OPTIONS="suppressions=\"$scratch/leaks.txt\":print_suppressions=0"
export UBSAN_OPTIONS=print_stacktrace=1
# Readers that work on files write them here.
export TMPDIR=$scratch

targets=("$@")
if ((${#targets[@]} == 0)); then
  for program in "$build"/fuzz/*; do targets+=("$(basename "$program")"); done
fi
failed=0
for target in "${targets[@]}"; do
  corpus=$build/corpus/$target
  log=$build/findings/$target.log
  mkdir -p "$corpus"
  "$build/fuzz/$target" --seeds="$corpus" >/dev/null
  # A reader that needs much more memory or time than this for so few bytes has
  # believed what a file says of itself.
  started=$SECONDS
  findings=0
  "$build/fuzz/$target" -max_total_time="$seconds" -timeout=20 \
    -rss_limit_mb=4096 -malloc_limit_mb=1024 -max_len=65536 \
    -print_final_stats=1 -close_fd_mask=3 \
    -artifact_prefix="$build/findings/$target-" "$corpus" \
    >"$log" 2>&1 || findings=1
  executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  printf '%-36s %5d s %10s executions %d findings\n' \
    "$target" $((SECONDS - started)) "${executions:-?}" "$findings"
  if ((findings)); then
    failed=1
    grep -m 3 -E 'SUMMARY|ERROR|runtime error' "$log" || tail -n 5 "$log"
  else
    rm "$log"
  fi
done
exit "$failed"
