#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Evaluates FreeGS on 3D-OVS: reconstructs each scene from the photographs that have
# no masks, asks for its classes, and writes a table of mIoU.
#
#   scripts/reproduce_3dovs.sh [--dry-run] DATA [OPTION ...]
#
# DATA is the folder that holds bed/, bench/, room/, sofa/ and lawn/.
# reproduce_common.sh lists the variables of the environment. The photographs that
# have masks are the test views. They are not trained on, as in the paper. Many
# other published figures come from views that were trained on.
set -euo pipefail
shopt -s extglob
benchmark=3dovs
scenes=(bed bench room sofa lawn)
get_data="3D-OVS comes with https://github.com/Kunhao-Liu/3D-OVS (Liu et al. \
2023), which links to it: give the folder that holds bed/, bench/, room/, \
sofa/ and lawn/."
# shellcheck source=scripts/reproduce_common.sh
source "$(dirname "${BASH_SOURCE[0]}")/reproduce_common.sh"
parse_arguments "$@"

# The photographs that have masks. Numbers may have other leading zeros.
write_holdout_list() {
  local scene=$1 photo folder name
  local -A test=()
  for folder in "$scene"/segmentations/*/; do
    name=$(basename -- "$folder")
    test[${name##+(0)}/]=1
  done
  for photo in "$scene"/images/*; do
    name=$(stem "$photo")
    if [[ -n ${test[${name##+(0)}/]:-} ]]; then printf '%s\n' "${photo##*/}"; fi
  done
}

# All data are looked at before the first scene takes its hours.
for scene in "${scenes[@]}"; do
  folder=$data/$scene
  [[ -d $folder/segmentations ]] ||
    fail "$folder/segmentations: no such folder. $get_data"
  has_images "$folder/images" || fail "$folder/images: no photographs. $get_data"
  mkdir -p -- "$out/$scene"
  write_holdout_list "$folder" >"$out/$scene/holdout.txt"
  [[ -s $out/$scene/holdout.txt ]] ||
    fail "$folder: no photograph has the name of a folder in segmentations/"
done

for scene in "${scenes[@]}"; do
  folder=$data/$scene
  sparse=$(sparse_of "$folder")
  poses=()
  # The original has no COLMAP model; then the program finds the poses.
  if [[ -n $sparse ]]; then poses=(--sfm.import "$sparse"); fi
  reproduce "$scene" "$folder/images" "$folder" 3dovs \
    --ingest.holdout_list "$out/$scene/holdout.txt" "${poses[@]}"
done

# shellcheck disable=SC2034  # By name.
{
  keys=(text_miou text_mbiou instance_miou click_miou view_consistency
    holdout_psnr num_gaussians)
  declare -A paper=([bed]=0.795 [bench]=0.861 [room]=0.701 [sofa]=0.819 [lawn]=0.674)
}
write_table keys paper
