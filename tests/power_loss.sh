#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Takes the power away at every rename of a run: copies the workspace with only
# what was flushed to disk by then, runs again from the copy, and checks that
# finished stages are there and that the end has the bytes of an undisturbed run.
# Then lets the disk refuse what a stage wrote.
#
#   tests/power_loss.sh BIN FOLDER [EVERY [OPTION ...]]
#
# BIN is the folder of the built programs with the tests. FOLDER is made anew.
# EVERY is how many renames apart the losses are (default: 1). OPTIONs go to all
# runs. tests/power_loss/power_loss.cc says what a copy
# has.
set -uo pipefail
unset CDPATH  # It would lead cd to other folders.
trap 'exit 130' INT TERM

program=$(realpath "$1")/freegs_pipeline
maker=$(realpath "$1")/freegs_make_scene
libraries=$(realpath "$1")
library=libfreegs_power_loss.so
every=${3:-1}
mkdir -p "$2"
cd "$2" || exit 1
shift $(($# < 3 ? $# : 3))
options=(--reconstruct.iterations 300 --reconstruct.budget 2000 --threads 1
  --general.checkpoint_interval 1 --bootstrap.mode geometry "$@")

if [ "$(stat -c %w .)" = - ]; then
  echo "skipped: this file system keeps no time of birth, by which files are told apart"
  exit 77
fi
rm -rf scene undisturbed cut shadow w
"$maker" --out scene --views 12 --width 240 --height 180 >out.txt 2>&1 ||
  { cat out.txt; exit 1; }
run() { "$program" run scene/images "$1" "${options[@]}" >out.txt 2>&1; }
run undisturbed || { cat out.txt; exit 1; }
# Spaces would end a path in LD_PRELOAD.
run_watched() {
  LD_LIBRARY_PATH=$libraries${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH} LD_PRELOAD=$library \
    POWER_LOSS_ROOT=$PWD/$1 POWER_LOSS_SHADOW=$PWD/shadow run "$1"
}
POWER_LOSS_EVERY=$every run_watched cut || { cat out.txt; exit 1; }

same() {
  local file
  for file in sfm/sparse/0/images.bin reconstruct/point_cloud.ply \
    bootstrap/idsf.bin; do
    cmp -s "$1/$file" "undisturbed/$file" || return 1
  done
}

[ -d shadow/cuts/0000 ] || { echo "$library kept nothing"; exit 1; }
losses=0 lost=0
fail() {
  echo "LOST  $1"
  tail -n 5 out.txt | sed 's/^/      /'
  lost=$((lost + 1))
}
for cut in shadow/cuts/*; do
  for kind in strict reordered; do
    losses=$((losses + 1))
    name="$(basename "$cut") $kind"
    # Where the loss comes within the last steps of a stage, all of it is still
    # in STAGE.partial or STAGE.old.
    : >out.txt
    for stage in $(sed -n 's/.* \([a-z]*\): done in .*/\1/p' "$cut/log.txt" 2>/dev/null); do
      grep -qs '"done"' "$cut/$kind/$stage"{,.partial,.old}/stage.json ||
        fail "$name: $stage was done"
    done
    for file in "$cut"/reordered/*/checkpoints/*.ckpt; do
      [ ! -s "$file" ] || compgen -G "$cut/$kind/*/checkpoints/*.ckpt" >/dev/null ||
        fail "$name: a checkpoint was written"
    done
    rm -rf w && cp -a "$cut/$kind" w
    { run w && same w; } || fail "$name: the next run"
  done
done

# What the disk did not take is not done, and the next run goes on.
rm -rf w && cp -a undisturbed w && rm -r w/reconstruct w/bootstrap w/export
POWER_LOSS_EVERY=1000000 POWER_LOSS_REFUSED=reconstruct.partial run_watched w
[ $? = 1 ] && grep -q 'reconstruct.partial: cannot write' out.txt &&
  [ ! -e w/reconstruct ] || fail "what the disk refused counts as done"
{ run w && same w; } || fail "the run after the disk refused"

[ $lost = 0 ] || { echo "$lost of $losses losses of power cost something"; exit 1; }
echo "nothing is lost in $losses losses of power"
