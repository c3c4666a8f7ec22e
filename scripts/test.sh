#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Does everything that a change has to pass: installs missing packages, checks the
# formatting, builds with warnings as errors, and runs all tests.
#
#   scripts/test.sh [CMAKE_ARGUMENT ...]     e.g. -DFREEGS_BUILD_BENCHMARKS=ON
#
# A build folder keeps these arguments. scripts/sanitize.sh builds with sanitizers, in
# folders of its own. At the end there is a list of the tests that were skipped.
# The variable BUILD names the build folder (default: build). FREEGS_SHARED_DATA may
# name a folder of reference data. Tests that need it are skipped without it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build=${BUILD:-build}
jobs=$(nproc)

scripts/install_packages.sh --tests

echo "== formatting"
if git rev-parse --is-inside-work-tree >/dev/null 2>&1; then
  git ls-files -z -- '*.cc' '*.h' |
    xargs -0 --no-run-if-empty clang-format-14 --dry-run -Werror
else
  echo "not a git checkout: skipped"
fi

echo "== build"
scripts/configure.sh "$build" -DFREEGS_BUILD_TESTS=ON "$@"
cmake --build "$build" --parallel "$jobs"

prettier=$build/web/node_modules/.bin/prettier
if [[ -x $prettier ]]; then
  echo "== formatting of the page"
  "$prettier" --check web tests/web
fi

echo "== tests"
ctest --test-dir "$build" --output-on-failure --no-tests=error --parallel "$jobs" |
  tee "$build/ctest.log"

# Tests of GoogleTest, and whole tests of ctest with the reason that they gave.
echo "== skipped"
last=$build/Testing/Temporary/LastTest.log
sed -nE 's/^\[  SKIPPED \] (.*) \([0-9]+ ms\)$/\1/p' "$last"
sed -nE 's/^.* Test +#[0-9]+: ([^ ]+) .*\*\*\*Skipped .*/\1/p' "$build/ctest.log" |
  while read -r name; do
    reason=$(sed -n "/ Testing: $name\$/,/^<end of output>/p" "$last" |
      grep -i -m 1 '^[^"]*skipped') || true
    echo "$name: $reason"
  done
