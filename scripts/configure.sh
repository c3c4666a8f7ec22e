#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Configures a build folder with CMake. Uses Ninja and ccache if they are installed.
#
#   scripts/configure.sh BUILD_FOLDER [CMAKE_ARGUMENT ...]
set -euo pipefail
unset CDPATH  # It would lead cd to other folders.
cd "$(dirname "${BASH_SOURCE[0]}")/.."

build=${1:?usage: scripts/configure.sh BUILD_FOLDER [CMAKE_ARGUMENT ...]}
shift
arguments=()
# A folder that was configured before keeps its generator.
if [[ ! -f $build/CMakeCache.txt ]] && command -v ninja >/dev/null; then
  arguments+=(-G Ninja)
fi
if command -v ccache >/dev/null; then
  # ccache keeps what was compiled with precompiled headers only with these.
  arguments+=("-DCMAKE_CXX_COMPILER_LAUNCHER=env;CCACHE_SLOPPINESS=pch_defines,time_macros;ccache")
fi
cmake -S . -B "$build" "${arguments[@]}" "$@"
