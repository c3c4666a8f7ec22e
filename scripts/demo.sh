#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Makes a 3D scene, beginning with a clean checkout: installs packages, builds the
# program, draws sample photos if none are given, and runs the whole pipeline.
#
#   scripts/demo.sh [IMAGES [OPTION ...]]
#
# IMAGES is a folder of photos. Options are passed to `freegs_pipeline run`, for
# example --preset balanced. The result is in demo_workspace of the checkout. If
# the script is run again, it goes on from there.
set -euo pipefail
here=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build=${BUILD:-build}
photos=demo_photos
workspace=demo_workspace

images=""
if (($# > 0)) && [[ $1 != --* ]]; then
  images=$(cd "$here" && realpath -- "$1")
  shift
fi

scripts/install_packages.sh
scripts/configure.sh "$build" >/dev/null
cmake --build "$build" --parallel "$(nproc)" \
  --target freegs_pipeline freegs_make_scene
program=$build/bin/freegs_pipeline

truth=""
if [[ -z $images ]]; then
  if [[ ! -f $photos/gt/cameras.json ]]; then
    "$build/bin/freegs_make_scene" --out "$photos" --views 40 \
      --width 640 --height 480 --seed 1
  fi
  images=$photos/images
  truth=$photos
fi

"$program" doctor
"$program" run "$images" "$workspace" --preset fast "$@"
"$program" status "$workspace"
if [[ -n $truth ]]; then
  "$program" eval "$workspace" --gt "$truth" --json "$workspace/eval.json"
fi

cat <<END

The scene lies in $workspace:
  page       $workspace/export/report/index.html    the scene in 3D, and its figures
  Gaussians  $workspace/reconstruct/point_cloud.ply
  renders    $workspace/reconstruct/holdout/
  objects    $workspace/bootstrap/instances.json
Ask it in words and with pictures, in the browser, with
  $program view $workspace --open
Look at other views with
  $program render $workspace --out DIR
END
