#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Files of a finished workspace that somebody deletes, edits, swaps, or dates anew.
#
#   tests/faults/outputs.sh BIN FOLDER [short]
#
# common.sh says the rest.
# shellcheck source=tests/faults/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

options+=("${known_poses[@]}" --reconstruct.iterations 60)
ply=w/reconstruct/point_cloud.ply

finished_workspace() { rm -rf w && cp -a reference w; }

# takes_files_of_date_as_they_are DATE: the dates of files say nothing.
takes_files_of_date_as_they_are() {
  finished_workspace
  find w -exec touch -hd "$1" {} +
  run w && [ "$(grep -c 'up to date' out.txt)" = 6 ]
}
# makes_deleted_output_again FILE: or the message says how. Without stage.json a folder
# counts as somebody else's.
makes_deleted_output_again() {
  local code
  finished_workspace
  rm -r "w/$1"
  run w
  code=$?
  case $1 in
    */stage.json) [ $code = 3 ] && grep -q "delete it" out.txt ;;
    */logs | */checkpoints | */features | sfm/database.db)
      [ $code = 0 ] && same_scene w && ! grep -q "deleted" out.txt ;;
    *) [ $code = 0 ] && same_scene w &&
      { [ -e "w/$1" ] || grep -q "deleted (to make it again: freegs_pipeline stage" out.txt; } ;;
  esac
}
makes_anew_what_follows_edited_ply() {
  finished_workspace
  printf '\001' |
    dd of=$ply bs=1 seek=$(($(stat -c %s $ply) - 1)) conv=notrunc 2>/dev/null
  run w --to bootstrap &&
    grep -q "bootstrap: input reconstruct/point_cloud.ply changed" out.txt
}
refuses_field_of_another_scene() {
  finished_workspace
  fresh other ingest sfm undistort
  "$program" run scene/images other "${options[@]/2000/500}" --to bootstrap >out.txt 2>&1
  cp other/bootstrap/idsf.bin w/bootstrap/idsf.bin
  "$program" render w --what instances --out r >out.txt 2>&1
  [ $? = 3 ] && grep -q "stage bootstrap" out.txt
}
tells_how_to_make_cut_ply_again() {
  finished_workspace
  truncate -s 3000 $ply
  ! run w --to bootstrap && grep -q "stage reconstruct" out.txt &&
    "$program" stage reconstruct w >out.txt 2>&1 && runs_to_same_scene w --to bootstrap
}

run_undisturbed reference
for date in 1990-01-01 2090-01-01; do
  report "all files dated $date" takes_files_of_date_as_they_are "$date"
done
for file in $(every_fifth_if_short reference/*/*) reference/ingest/photos/frame_0002.jpg \
  reference/undistort/images/frame_0003.jpg reference/sfm/sparse/0/points3D.bin; do
  report "${file#reference/} deleted" makes_deleted_output_again "${file#reference/}"
done
report "point_cloud.ply edited: what follows is made anew" makes_anew_what_follows_edited_ply
report "idsf.bin of another scene: told how to make it again" refuses_field_of_another_scene
report "point_cloud.ply cut short: told how to make it again" tells_how_to_make_cut_ply_again
verdict
