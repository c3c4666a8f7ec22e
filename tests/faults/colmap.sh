#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# A COLMAP that is killed, hangs, forks or lies.
#
#   tests/faults/colmap.sh BIN FOLDER [short]
#
# common.sh says the rest.
# shellcheck source=tests/faults/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

options+=(--to sfm)
with_fake=(--sfm.colmap "$PWD/fake_colmap")

# write_fake_colmap COMMAND SCRIPT: a COLMAP that at COMMAND does what SCRIPT says first.
write_fake_colmap() {
  cat >fake_colmap <<END
#!/bin/bash
if [ "\$1" = $1 ] && [ "\$2" != --help ]; then
  $2
fi
exec colmap "\$@"
END
  chmod +x fake_colmap
  rm -rf w
}
runs_to_same_poses() { run w "$@" && same_poses w; }

# survives_killed_colmap COMMAND SIGNAL: the next run goes on from what was finished.
survives_killed_colmap() {
  local numbered
  write_fake_colmap "$1" "rm ${PWD@Q}/once 2>/dev/null && kill -$2 \$\$"
  touch once
  run w "${with_fake[@]}"
  [ $? = 1 ] || return 1
  numbered=$(stat -c '%y %i' w/sfm*/logs/feature_extractor.log)
  runs_to_same_poses "${with_fake[@]}" && { [ "$1" = feature_extractor ] ||
    [ "$(stat -c '%y %i' w/sfm*/logs/feature_extractor.log)" = "$numbered" ]; }
}
ends_hanging_colmap() {
  write_fake_colmap mapper 'sleep 1000'
  begin w/sfm.partial/logs/mapper.log "${with_fake[@]}"
  sleep 1
  expect_exit_after_signals 130 INT && runs_to_same_poses
}
# leaves_no_child_of_colmap SIGNAL CODE: the signal comes twice, and the run ends with
# the exit code.
leaves_no_child_of_colmap() {
  write_fake_colmap feature_extractor "sleep 1000 & echo \$! >${PWD@Q}/grandchild; wait"
  rm -f grandchild
  begin grandchild "${with_fake[@]}"
  sleep 0.3
  expect_exit_after_signals "$2" "$1" "$1" || return 1
  sleep 0.5
  [ -s grandchild ] && ! grep -qs sleep "/proc/$(cat grandchild)/cmdline"
}
refuses_model_of_noise() {
  # shellcheck disable=SC2016  # The fake expands it.
  write_fake_colmap mapper 'while [ "$1" != --output_path ]; do shift; done
  mkdir "$2/0"
  for f in cameras images points3D; do head -c 100 /dev/urandom >"$2/0/$f.bin"; done
  exit 0'
  ! run w "${with_fake[@]}" && [ ! -e w/sfm ] && runs_to_same_poses
}

run_undisturbed reference_poses
for fault in $(every_fifth_if_short {mapper,feature_extractor,matches_importer}:{KILL,SEGV}); do
  report "colmap ${fault%:*} ended by SIG${fault#*:}" \
    survives_killed_colmap "${fault%:*}" "${fault#*:}"
done
report "colmap hangs: Ctrl-C" ends_hanging_colmap
report "colmap forks: nothing lives on after SIGKILL twice" leaves_no_child_of_colmap KILL 137
report "colmap forks: nothing lives on after SIGINT twice" leaves_no_child_of_colmap INT 130
report "colmap lies: its model is noise" refuses_model_of_noise
verdict
