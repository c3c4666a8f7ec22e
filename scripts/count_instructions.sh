#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Counts the processor instructions of five training steps with callgrind (a tool
# of valgrind), and compares them with the number in scripts/instructions.txt. The
# count is a measure of speed that does not depend on what else the machine does.
#
#   scripts/count_instructions.sh BUILD [--write]
#
# The steps are made on a drawn scene of 80 x 60 pixels, with AVX2, the widest
# instructions that valgrind knows. --write puts the new number into the file. Exit
# codes:
#   0    the number is the same within 3 %
#   4    it is not
#   77   it cannot be compared: there is no valgrind, it does not know an instruction
#        of this processor, there is no AVX2, no Release build, or no number for this
#        compiler in the file
set -euo pipefail
unset CDPATH  # It would lead cd to other folders.

build=$(realpath "${1:?usage: scripts/count_instructions.sh BUILD [--write]}")
numbers=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/instructions.txt
tolerance=3 # Percent.

skip() {
  echo "[  SKIPPED ] $1"
  exit 77
}
command -v valgrind >/dev/null || skip "there is no valgrind"
grep -qw avx2 /proc/cpuinfo || skip "this processor has no AVX2"
grep -q '^CMAKE_BUILD_TYPE:[A-Z]*=Release$' "$build/CMakeCache.txt" ||
  skip "not a Release build"

# Libraries choose instructions by the processor, and a valgrind that is older than
# the processor may not know them. SIGILL ends with 128 + 4.
status=0
valgrind --tool=none "$build/bin/freegs_pipeline" --version \
  >/dev/null 2>&1 || status=$?
((status != 132)) || skip "valgrind does not know an instruction of this processor"

compiler=$(sed -n 's/^CMAKE_CXX_COMPILER:[A-Z]*=//p' "$build/CMakeCache.txt")
version=$("$compiler" --version | head -n 1)
name=$([[ $version == *clang* ]] && echo clang || echo gcc)-$("$compiler" -dumpversion | cut -d. -f1)

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
quietly() {
  "$@" >"$folder/log" 2>&1 || { tail -n 20 "$folder/log" >&2; exit 1; }
}
options=(--threads 1 --sfm.import "$folder/scene/gt/transforms.json"
  --sfm.random_points 1000 --reconstruct.iterations 5
  --reconstruct.exposure off --reconstruct.densification none)
quietly "$build/bin/freegs_make_scene" --out "$folder/scene" --views 4 \
  --test_views 1 --width 80 --height 60
quietly "$build/bin/freegs_pipeline" run "$folder/scene/images" "$folder/w" \
  --to undistort "${options[@]}"
quietly valgrind --tool=callgrind --callgrind-out-file="$folder/out" \
  --toggle-collect='freegs::splat::Trainer::Step*' \
  "$build/bin/freegs_pipeline" run "$folder/scene/images" "$folder/w" \
  --from reconstruct --to reconstruct "${options[@]}"
count=$(sed -n 's/^totals: //p' "$folder/out")
[[ $count -gt 0 ]] || { echo "no step was counted" >&2; exit 1; }

if [[ ${2:-} == --write ]]; then
  touch "$numbers"
  sed -i "/^$name /d" "$numbers"
  echo "$name $count" >>"$numbers"
fi
before=$(sed -n "s/^$name //p" "$numbers")
[[ -n $before ]] || skip "no number for $name in $numbers; it is $count"
echo "$name: $count instructions for five steps, before $before"
if ((100 * (count > before ? count - before : before - count) > tolerance * before)); then
  echo "more than $tolerance % apart; if that is meant, call this with --write" >&2
  exit 4
fi
