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
rm -rf -- "$folder/installed" "$folder/build"
echo "passed"
