#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Tests the Debian package that cpack made: makes a new Debian 12 in a folder of its
# own, installs the package there, and runs the whole pipeline in it.
#
#   scripts/package_test.sh [PHOTOS [OPTION ...]]
#
# PHOTOS is a folder of photos. Without it the scene maker of the build draws 24.
# Options are passed to `freegs_pipeline run` (default: --preset fast). The script
# needs root and debootstrap. It reads these variables of the environment, and
# those of scripts/new_system.sh:
#   BUILD    the build folder, where cpack was run (default: build)
#   DEVELOPMENT   if it is not empty, freegs-pipeline-dev is installed as well, and
#            examples/render_scene is built and run with it (2 GB more)
set -euo pipefail
unset CDPATH  # It would lead cd to other folders.
here=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build=${BUILD:-build}

source scripts/new_system.sh
photos=""
if (($# > 0)) && [[ $1 != --* ]]; then
  photos=$(cd "$here" && realpath -- "$1")
  [[ -d $photos ]] || fail 3 "$photos: no such folder"
  shift
fi
options=("$@")
((${#options[@]} > 0)) || options=(--preset fast)
packages=("$build"/freegs-pipeline_*_"$(dpkg --print-architecture)".deb)
((${#packages[@]} == 1)) && [[ -f ${packages[0]} ]] ||
  fail 3 "$build holds not just one freegs-pipeline_*.deb; run cpack there"
make_system

step "installing ${packages[0]##*/}"
mkdir -- "$system/trial"
cp -- "${packages[0]}" "$system/trial/package.deb"
inside apt-get install -q -y --no-install-recommends /trial/package.deb \
  >"$system/trial/apt.log" || fail 1 "apt failed; see the end: $(tail -5 "$system/trial/apt.log")"
inside dpkg-query -W -f='${Package} ${Version}, ${Installed-Size} kB\n' freegs-pipeline

step "what the program finds"
inside freegs_pipeline --version
inside freegs_pipeline doctor
for file in bash-completion/completions/freegs_pipeline \
  zsh/vendor-completions/_freegs_pipeline man/man1/freegs_pipeline.1.gz \
  freegs_pipeline/web/viewer.js \
  freegs_pipeline/workspace_template/config.ini doc/freegs-pipeline/copyright \
  doc/freegs-pipeline/changelog.gz; do
  [[ -s $system/usr/share/$file ]] || fail 1 "/usr/share/$file is missing"
done

step "a run"
if [[ -n $photos ]]; then
  cp -rL -- "$photos" "$system/trial/photos"
else
  "$build/bin/freegs_make_scene" --out "$system/trial/drawn" --views 24 \
    --width 480 --height 360 --seed 1 >/dev/null 2>&1
  mv -- "$system/trial/drawn/images" "$system/trial/photos"
fi
# /trial is a folder of the new system.
inside sh -c 'cd /trial && exec freegs_pipeline run photos workspace "$@"' \
  sh "${options[@]}"
inside freegs_pipeline status /trial/workspace
for file in reconstruct/point_cloud.ply bootstrap/instances.json \
  export/report/index.html; do
  [[ -s $system/trial/workspace/$file ]] || fail 1 "workspace/$file is missing"
done
# The page holds its script, so the bundle was found.
grep -q 'WebGL' "$system/trial/workspace/export/report/index.html" ||
  fail 1 "the page has no 3D view"
inside freegs_pipeline query /trial/workspace --text "red ball"

if [[ -n ${DEVELOPMENT:-} ]]; then
  step "a program of one's own"
  cp -- "$build"/freegs-pipeline-dev_*_"$(dpkg --print-architecture)".deb \
    "$system/trial/development.deb"
  cp -r -- examples/render_scene "$system/trial/"
  inside apt-get install -q -y --no-install-recommends g++ make cmake \
    /trial/development.deb >"$system/trial/apt.log" 2>&1 ||
    fail 1 "apt failed; see the end: $(tail -5 "$system/trial/apt.log")"
  inside sh -ec 'cd /trial/render_scene && cmake -B build && cmake --build build &&
    build/render_scene scene.ply camera.txt picture.png'
fi

step "removing the package"
inside apt-get purge -q -y 'freegs-pipeline*' >/dev/null 2>&1
left=$(find "$system/usr" "$system/etc" -iname '*freegs*')
[[ -z $left ]] || fail 1 "the package leaves behind: $left"
step "passed"
