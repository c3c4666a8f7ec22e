# shellcheck shell=bash
# SPDX-License-Identifier: BSD-3-Clause
# The part that all scripts of this folder have. They read it with `source`, and it
# takes their arguments:
#
#   tests/faults/NAME.sh BIN FOLDER [short]
#
# BIN is the folder of the built programs. FOLDER is made anew, with a small drawn
# scene in it, and is the current folder from then on. Each script prints one line per
# fault, and fails when something is lost or when a run cannot be taken up again. The
# short form tries every fifth case where there are many of a kind.
set -uo pipefail
unset CDPATH  # It would lead cd to other folders.

bin=$(realpath "$1")
program=$bin/freegs_pipeline
form=${3:-whole}
failures=0
# Options of all runs; known_poses are for those that do not ask COLMAP. A script that
# needs more than one thread sets num_threads before it reads this.
options=(--reconstruct.budget 2000 --threads "${num_threads:-1}" --bootstrap.mode geometry)
# shellcheck disable=SC2034  # For those who source this.
known_poses=(--sfm.import scene/gt/transforms.json --sfm.random_points 3000)

# Nothing that was begun lives on.
kill_jobs() {
  local left
  left=$(jobs -pr)
  # shellcheck disable=SC2086
  [ -z "$left" ] || kill -KILL $left
  wait
}

# run WORKSPACE OPTION...: what it says is in out.txt.
run() { "$program" run scene/images "$@" "${options[@]}" >out.txt 2>&1; }
# Makes a workspace to compare with: same_scene does so with reference, and same_poses,
# for poses by COLMAP, with reference_poses.
run_undisturbed() { run "$@" || { cat out.txt; exit 1; }; }
same_scene() {
  cmp -s "$1/reconstruct/point_cloud.ply" reference/reconstruct/point_cloud.ply &&
    cmp -s "$1/bootstrap/idsf.bin" reference/bootstrap/idsf.bin
}
same_poses() { cmp -s "$1/sfm/sparse/0/images.bin" reference_poses/sfm/sparse/0/images.bin; }
runs_to_same_scene() { run "$@" && same_scene "$1"; }

# A new workspace in which the first stages are done: fresh WORKSPACE STAGE...
fresh() {
  local workspace=$1 stage
  shift
  rm -rf "$workspace" && mkdir "$workspace"
  for stage in workspace.json "$@"; do cp -a "reference/$stage" "$workspace/"; done
}

# Begins a run in w, whose process is $pid, and waits until a file appears:
# begin PATTERN OPTION...
begin() {
  : >out.txt
  "$program" run scene/images w "${@:2}" "${options[@]}" >out.txt 2>&1 &
  pid=$!
  until compgen -G "$1" >/dev/null || ! kill -0 "$pid" 2>/dev/null; do sleep 0.05; done
}
# Sends signals to the run that was begun: expect_exit_after_signals CODE SIGNAL...
expect_exit_after_signals() {
  local signal
  for signal in "${@:2}"; do kill "-$signal" "$pid" 2>/dev/null; done
  wait "$pid" 2>/dev/null
  [ $? = "$1" ]
}

# Prints the values, or every fifth one in the short form.
every_fifth_if_short() {
  local step=1 at
  [ "$form" = short ] && step=5
  for ((at = 1; at <= $#; at += step)); do echo "${!at}"; done
}

# report NAME TRUE|FALSE-COMMAND...: one line, and the log of what went wrong.
report() {
  if "${@:2}"; then
    echo "held  $1"
  else
    echo "LOST  $1"
    tail -n 5 out.txt | sed 's/^/      /'
    failures=$((failures + 1))
  fi
}
# The last command of each script.
verdict() {
  [ $failures = 0 ] || { echo "$failures faults cost something"; exit 1; }
  echo "nothing is lost"
}

trap kill_jobs EXIT
trap 'exit 130' INT TERM
mkdir -p "$2"
cd "$2" || exit 1
rm -rf scene reference reference_poses w
"$bin/freegs_make_scene" --out scene --views 12 --width 240 --height 180 >out.txt 2>&1 ||
  { cat out.txt; exit 1; }
