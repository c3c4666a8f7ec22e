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
unset CDPATH  # It would lead cd to other folders.
if [[ ${1:-} == --help || ${1:-} == -h ]]; then
  sed -n '3,/^set /s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
  exit
fi
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build=${BUILD:-build}
jobs=$(nproc)

scripts/install_packages.sh --tests

echo "== formatting"
# All files, but for those of build folders, of packages, and of hidden folders.
find . -mindepth 1 -type d \( -name '.*' -o -name node_modules -o \
  -exec test -e '{}/CMakeCache.txt' \; \) -prune -o \
  -type f \( -name '*.cc' -o -name '*.h' \) -print0 |
  xargs -0 clang-format-14 --dry-run -Werror

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
[[ -x $prettier ]] ||
  echo "formatting and tests of the page, which is not built (FREEGS_BUILD_WEB)"
last=$build/Testing/Temporary/LastTest.log
sed -nE 's/^\[  SKIPPED \] (.*) \([0-9]+ ms\)$/\1/p' "$last"
sed -nE 's/^.* Test +#[0-9]+: ([^ ]+) .*\*\*\*Skipped .*/\1/p' "$build/ctest.log" |
  while read -r name; do
    reason=$(sed -n "/ Testing: $name\$/,/^<end of output>/p" "$last" |
      grep -i -m 1 '^[^"]*skipped') || true
    echo "$name: $reason"
  done
