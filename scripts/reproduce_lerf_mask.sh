#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Evaluates FreeGS on LERF-Mask: reconstructs each scene from its training
# photographs, asks for its phrases, and writes a table of mIoU and boundary mIoU.
#
#   scripts/reproduce_lerf_mask.sh [--dry-run] DATA [OPTION ...]
#
# DATA is the folder that holds figurines/, ramen/ and teatime/. reproduce_common.sh
# lists the variables of the environment.
set -euo pipefail
benchmark=lerf_mask
scenes=(figurines ramen teatime)
get_data="LERF-Mask comes with Gaussian Grouping (Ye et al. 2024): download \
data/lerf_mask of https://huggingface.co/mqye/Gaussian-Grouping, unpack it, \
and give the folder that holds figurines/, ramen/ and teatime/."
# shellcheck source=scripts/reproduce_common.sh
source "$(dirname "${BASH_SOURCE[0]}")/reproduce_common.sh"
parse_arguments "$@"

# The photographs that are not in images_train.
write_holdout_list() {
  local scene=$1 photo
  local -A train=()
  for photo in "$scene"/images_train/*; do train[$(stem "$photo")]=1; done
  for photo in "$scene"/images/*; do
    if [[ -z ${train[$(stem "$photo")]:-} ]]; then printf '%s\n' "${photo##*/}"; fi
  done
}

# All data are looked at before the first scene takes its hours.
for scene in "${scenes[@]}"; do
  folder=$data/$scene
  [[ -d $folder/test_mask ]] || fail "$folder/test_mask: no such folder. $get_data"
  for part in images images_train; do
    has_images "$folder/$part" || fail "$folder/$part: no photographs. $get_data"
  done
done

for scene in "${scenes[@]}"; do
  folder=$data/$scene
  sparse=$(sparse_of "$folder")
  mkdir -p -- "$out/$scene"
  write_holdout_list "$folder" >"$out/$scene/holdout.txt"
  poses=()
  # With the poses of the data set, as everybody.
  if [[ -n $sparse ]]; then poses=(--sfm.import "$sparse"); fi
  reproduce "$scene" "$folder/images" "$folder" lerf_mask \
    --ingest.holdout_list "$out/$scene/holdout.txt" "${poses[@]}"
done

# shellcheck disable=SC2034  # By name.
{
  keys=(text_miou text_mbiou instance_miou click_miou view_consistency
    holdout_psnr num_gaussians)
  declare -A paper=([figurines]=0.626 [ramen]=0.775 [teatime]=0.685)
}
write_table keys paper
