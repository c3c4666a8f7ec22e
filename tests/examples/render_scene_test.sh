#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Installs the libraries from a build folder into an empty place, builds the
# example against them, as anybody would, and renders a picture with it.
#
#   tests/examples/render_scene_test.sh BUILD FOLDER [CMAKE_ARGUMENT ...]
#
# FOLDER is emptied first. A build folder that lacks a library fails.
set -euo pipefail
unset CDPATH  # It would lead cd to other folders.
example=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../examples/render_scene" && pwd)
build=${1:?usage: render_scene_test.sh BUILD FOLDER [CMAKE_ARGUMENT ...]}
folder=${2:?usage: render_scene_test.sh BUILD FOLDER [CMAKE_ARGUMENT ...]}
shift 2

rm -rf -- "$folder"
mkdir -p -- "$folder"
cmake --install "$build" --prefix "$folder/installed" >"$folder/install.log"
cmake -S "$example" -B "$folder/build" \
  -DCMAKE_PREFIX_PATH="$folder/installed" "$@"
cmake --build "$folder/build"
said=$("$folder/build/render_scene" \
  "$example/scene.ply" "$example/camera.txt" "$folder/picture.png")
echo "$said"
[[ $said == "3 Gaussians cover 12."[0-9]*" % of $folder/picture.png" ]]
file=$(head -c 24 "$folder/picture.png" | od -An -tx1 | tr -d ' \n')
# The signature of PNG, and 320 x 240 in its header.
[[ $file == 89504e470d0a1a0a*00000140000000f0 ]]
code=0
"$folder/build/render_scene" "$example/camera.txt" "$example/camera.txt" \
  "$folder/none.png" || code=$?
((code == 3))

# Programs for a larger instruction set lay out the same structs.
mkdir -p -- "$folder/layout"
cat >"$folder/layout/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.22)
project(layout LANGUAGES CXX)
find_package(freegs_pipeline REQUIRED)
add_library(layout OBJECT layout.cc)
target_link_libraries(layout PRIVATE freegs::core)
END
cat >"$folder/layout/layout.cc" <<'END'
#include "core/rigid3d.h"
static_assert(alignof(freegs::Rigid3d) == 16);
END
flags=""
[[ $(uname -m) != x86_64 ]] || flags=-mavx
cmake -S "$folder/layout" -B "$folder/layout/build" "$@" \
  -DCMAKE_PREFIX_PATH="$folder/installed" -DCMAKE_CXX_FLAGS="$flags" >/dev/null
cmake --build "$folder/layout/build"

# A search that is not required goes on where something is missing.
mkdir -p -- "$folder/optional"
cat >"$folder/optional/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.22)
project(optional LANGUAGES CXX)
find_package(freegs_pipeline QUIET)
if(freegs_pipeline_FOUND OR TARGET freegs::splat)
  message(FATAL_ERROR "found, although something is missing")
endif()
END
cmake -S "$folder/optional" -B "$folder/optional/ceres" "$@" \
  -DCMAKE_PREFIX_PATH="$folder/installed" \
  -DCMAKE_DISABLE_FIND_PACKAGE_Ceres=ON >/dev/null
PKG_CONFIG_LIBDIR=$folder PKG_CONFIG_PATH="" \
  cmake -S "$folder/optional" -B "$folder/optional/modules" "$@" \
  -DCMAKE_PREFIX_PATH="$folder/installed" >/dev/null
rm -rf -- "$folder/installed" "$folder/build" "$folder/layout" "$folder/optional"
echo "passed"
