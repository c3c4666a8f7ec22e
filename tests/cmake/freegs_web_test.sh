#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Fetches the packages of the page by cmake/FreegsWeb.cmake, with stand-ins for Node.js
# and npm. The paths have spaces and apostrophes, which a shell reads as its own.
#
#   tests/cmake/freegs_web_test.sh
set -euo pipefail
unset CDPATH  # It would lead cd to other folders.
here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
checkout="$folder/Tom's check out"
build="$checkout/the build"
mkdir -p "$checkout/scripts" "$checkout/web/src" "$folder/Ann's programs"
cp -r -- "$here/../../cmake" "$checkout/"
touch "$checkout"/web/{package.json,package-lock.json,.npmrc,build.mjs,plot.mjs,live.html,tsconfig.json}
cat >"$checkout/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.22)
project(page LANGUAGES NONE)
include(cmake/FreegsWeb.cmake)
END

fail() {
  echo "FAILED: $1" >&2
  cat "$folder/out.txt" >&2
  exit 1
}
# stand_in PATH: a program whose script comes from standard input.
stand_in() {
  { echo '#!/bin/bash'; cat; } >"$1"
  chmod +x "$1"
}
stand_in "$folder/Ann's programs/node" <<<'echo v18.0.0'
stand_in "$folder/Ann's programs/npm" <<'END'
[[ ! -e $no_network ]] || exit 1
mkdir -p node_modules
END
# The script that the message proposes says what it was given.
stand_in "$checkout/scripts/configure.sh" <<<'printf "<%s>" "$@"'
export no_network=$folder/no_network
PATH="$folder/Ann's programs:$PATH"

for generator in Ninja "Unix Makefiles"; do
  program="make"
  [[ $generator != Ninja ]] || program="ninja"
  command -v $program >/dev/null || continue
  rm -rf -- "$build"
  cmake -S "$checkout" -B "$build" -G "$generator" >"$folder/out.txt" 2>&1 ||
    fail "$generator: cmake"
  touch "$no_network"
  ! cmake --build "$build" >"$folder/out.txt" 2>&1 || fail "$generator: no npm, no error"
  proposed=$(sed -n 's/^The packages .* To go on without its 3D view, run: \(.*\) and then .*/\1/p' \
    "$folder/out.txt")
  [[ -n $proposed ]] || fail "$generator: nothing is proposed"
  given=$(cd "$checkout" && eval "$proposed") || fail "$generator: cannot be pasted"
  [[ $given == "<$build><-DFREEGS_BUILD_WEB=OFF>" ]] || fail "$generator: $given"
  rm -- "$no_network"
  cmake --build "$build" >"$folder/out.txt" 2>&1 || fail "$generator: npm"
  [[ -e $build/web/node_modules/.package-lock.json ]] || fail "$generator: no packages"
  # A page of before would be taken for one of this program.
  mkdir -p "$build/share/freegs_pipeline/web"
  touch "$build/share/freegs_pipeline/web/viewer.js"
  cmake -DFREEGS_BUILD_WEB=OFF "$build" >"$folder/out.txt" 2>&1 || fail "$generator: off"
  [[ ! -e $build/share/freegs_pipeline/web ]] || fail "$generator: the page is still there"
done
echo "passed"
