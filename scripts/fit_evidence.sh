#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Learns the weights of the evidence for instances and of how good regions are anew
# (semantics/patches/evidence.json and region_quality.json), from two reconstructions
# each of 24 scenes that the scene maker draws, and judges them on twenty other scenes.
# docs/instances.md says what evidence is.
#
#   scripts/fit_evidence.sh BUILD FOLDER [FIRST_SEED [LAST_SEED]]
#
# BUILD is a build folder with FREEGS_BUILD_BENCHMARKS=ON. FOLDER gets the scenes and
# the new files. The scenes to learn from have the seeds 1 to 24, or those that are
# named; the scenes to judge on have the seeds 101 to 120, which cannot be among them. A
# reconstruction takes one to two minutes on 2 cores, and learning ten. Scenes that are
# in FOLDER already are not made again.
set -euo pipefail

first_judged=101
last_judged=120
refuse() {
  echo "error: $1" >&2
  echo "usage: scripts/fit_evidence.sh BUILD FOLDER [FIRST_SEED [LAST_SEED]]" >&2
  exit 2
}
(($# >= 2 && $# <= 4)) || refuse "takes two to four arguments"
bin=$1/bin
out=$2
first=${3:-1}
last=${4:-24}
for seed in "$first" "$last"; do
  [[ $seed =~ ^(0|[1-9][0-9]{0,8})$ ]] || refuse "$seed is not a seed"
done
((first <= last)) || refuse "the first seed, $first, is larger than the last, $last"
((last < first_judged || first > last_judged)) ||
  refuse "the scenes with the seeds $first_judged to $last_judged are those to judge on"
for program in freegs_make_scene freegs_pipeline freegs_fit_evidence; do
  [[ -x $bin/$program ]] || refuse "there is no $bin/$program"
done
mkdir -p -- "$out"

# make_scenes FIRST LAST: adds two reconstructions of each scene to the array scenes.
# One begins with points that are triangulated from the pictures, and is clear. The
# other begins with random points, and is hazy, as scenes of few or poor photographs
# are.
make_scenes() {
  local seed scene views arc iterations points workspace
  for seed in $(seq "$1" "$2"); do
    scene=$out/scene_$seed
    # All around the table, a part of it, few photographs, hardly any parallax;
    # and reconstructions of more than one quality.
    case $((seed % 4)) in
      0) views=40 arc=0 ;;
      1) views=20 arc=90 ;;
      2) views=30 arc=360 ;;
      *) views=16 arc=25 ;;
    esac
    iterations=$((1000 + 500 * (seed % 3)))
    if [[ ! -f $scene/gt/transforms.json ]]; then
      # Under its name there is never half a scene.
      rm -rf -- "$scene.partial"
      "$bin/freegs_make_scene" --scene clutter --out "$scene.partial" --seed "$seed" \
        --views "$views" --arc "$arc" --test_views 4 --width 480 --height 360
      mv -T -- "$scene.partial" "$scene"
    fi
    for points in 0 10000; do
      workspace=$out/workspace_${seed}_$points
      "$bin/freegs_pipeline" run "$scene/images" "$workspace" \
        --sfm.import "$scene/gt/transforms.json" --sfm.random_points "$points" \
        --reconstruct.iterations "$iterations" --to reconstruct
      scenes+=("$workspace" "$scene")
    done
  done
}

scenes=()
make_scenes "$first" "$last"
taught=("${scenes[@]}")
scenes=()
make_scenes "$first_judged" "$last_judged"
"$bin/freegs_fit_evidence" --train "${taught[@]}" --test "${scenes[@]}" --out "$out"
echo "$out/evidence.json, $out/region_quality.json: compare, then copy to semantics/patches"
