#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Builds the tests with sanitizers and runs them. Fails if a sanitizer reports anything.
#
#   scripts/sanitize.sh [address|thread [TEST_PROGRAM ...]]   e.g. thread core_test
#
# `address` (the default) finds wrong use of memory, leaks and undefined behaviour.
# `thread` finds data races. Without TEST_PROGRAM all tests run. The variable BUILD
# names the build folder (default: build-asan or build-tsan).
# tests/sanitizer_suppressions.txt lists reports about code that is not ours.
set -euo pipefail
unset CDPATH  # It would lead cd to other folders.
cd "$(dirname "${BASH_SOURCE[0]}")/.."

sanitizer=${1:-address}
shift || true
case $sanitizer in
  address) preset=asan ;;
  thread) preset=tsan ;;
  *) echo "usage: scripts/sanitize.sh [address|thread [TEST_PROGRAM ...]]" >&2
     exit 2 ;;
esac
build=${BUILD:-build-$preset}
targets=()
filter=()
if (($# > 0)); then
  targets=(--target "$@")
  filter=(--tests-regex "^($(IFS='|'; echo "$*"))[.]")
fi
scripts/configure.sh "$build" --preset "$preset" >/dev/null
cmake --build "$build" --parallel "$(nproc)" "${targets[@]}"

build=$(cd "$build" && pwd)
grep '^leak:' tests/sanitizer_suppressions.txt >"$build/leaks.txt" || true
grep -vE '^(leak:|#|$)' tests/sanitizer_suppressions.txt >"$build/races.txt" || true
# Code of ours asks for more memory than there is in some tests, and copes.
export ASAN_OPTIONS=allocator_may_return_null=1
export LSAN_OPTIONS="suppressions=\"$build/leaks.txt\":print_suppressions=0"
export TSAN_OPTIONS="allocator_may_return_null=1:suppressions=\"$build/races.txt\""
export UBSAN_OPTIONS=print_stacktrace=1
ctest --test-dir "$build" --output-on-failure --no-tests=error \
  --parallel "$(nproc)" "${filter[@]}"
