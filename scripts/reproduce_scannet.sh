#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Evaluates FreeGS on ScanNet: reconstructs each scan from every 20th frame with the
# scan's own poses, asks for the labels of its objects, and writes a table of 3D box
# mIoU and recall.
#
#   scripts/reproduce_scannet.sh [--dry-run] DATA [OPTION ...]
#
# DATA is the folder that holds scene0060_00/, scene0381_00/ and scene0462_00/. Each of
# them has the files of the scan, and the frames that ScanNet's SensReader exports
# (color/, pose/, intrinsic/). reproduce_common.sh lists the variables of the
# environment. One more is read here:
#   STEP   every how many-th frame is used (default: 20)
set -euo pipefail
benchmark=scannet
scenes=(scene0060_00 scene0381_00 scene0462_00)
get_data="ScanNet (Dai et al. 2017) is given to those who sign its terms of \
use, see https://github.com/ScanNet/ScanNet: download the scans' \
.aggregation.json, _vh_clean_2.ply, _vh_clean_2.0.010000.segs.json, .txt and \
.sens files, and export color/, pose/ and intrinsic/ with its SensReader."
# shellcheck source=scripts/reproduce_common.sh
source "$(dirname "${BASH_SOURCE[0]}")/reproduce_common.sh"
parse_arguments "$@"
step=${STEP:-20}
[[ $step =~ ^[1-9][0-9]*$ ]] || fail "STEP must be a whole number above 0"

# choose_frames SCAN TARGET: links every STEP-th frame that has a pose into
# TARGET/images and writes the poses to TARGET/transforms.json. Its axes are
# OpenGL's: those of y and z point the other way. ScanNet's pixel centres are
# whole numbers, ours are at +0.5.
choose_frames() {
  local scan=$1 target=$2 number photo comma=""
  rm -rf -- "$target/images"
  mkdir -p -- "$target/images"
  {
    # In other locales numbers would have commas.
    LC_ALL=C awk 'NR == 1 { printf "{\"fl_x\": %s, \"cx\": %.6f,\n", $1, $3 + 0.5 }
         NR == 2 { printf " \"fl_y\": %s, \"cy\": %.6f,\n", $2, $3 + 0.5 }' \
      "$scan/intrinsic/intrinsic_color.txt"
    printf ' "frames": ['
    for photo in "$scan"/color/*.jpg; do
      number=$(stem "$photo")
      [[ $number =~ ^[0-9]+$ ]] || continue
      ((10#$number % step == 0)) || continue
      [[ -f $scan/pose/$number.txt ]] || continue
      # Frames whose pose was lost say "-inf".
      if grep -q -i 'inf\|nan' "$scan/pose/$number.txt"; then continue; fi
      ln -s -- "$photo" "$target/images/$number.jpg"
      printf '%s\n  {"file_path": "images/%s.jpg", "transform_matrix": [' \
        "$comma" "$number"
      LC_ALL=C awk 'NF == 4 { printf "%s[%s, %.9g, %.9g, %s]", row++ ? ", " : "", \
                            $1, -$2, -$3, $4 }' "$scan/pose/$number.txt"
      printf ']}'
      comma=,
    done
    printf '\n]}\n'
  } >"$target/transforms.json"
  has_images "$target/images" || fail "$scan: no frame with a photo and a pose"
}

# All data are looked at before the first scene takes its hours.
for scene in "${scenes[@]}"; do
  folder=$data/$scene
  for part in color pose intrinsic; do
    [[ -d $folder/$part ]] || fail "$folder/$part: no such folder. $get_data"
  done
  [[ -f $folder/intrinsic/intrinsic_color.txt ]] ||
    fail "$folder/intrinsic/intrinsic_color.txt: no such file. $get_data"
  mkdir -p -- "$out/$scene"
  choose_frames "$folder" "$out/$scene"
done

for scene in "${scenes[@]}"; do
  folder=$data/$scene
  reproduce "$scene" "$out/$scene/images" "$folder" scannet \
    --sfm.import "$out/$scene/transforms.json"
done

# shellcheck disable=SC2034  # By name.
{
  keys=(text_box_miou text_box_recall50 text_box_recall25 box_miou box_recall50
    box_recall25 view_consistency holdout_psnr num_gaussians)
  declare -A paper=([scene0060_00]=0.137 [scene0381_00]=0.262 [scene0462_00]=0.145)
}
write_table keys paper
