#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# A workspace that cannot be written, and a disk that is full at ever later moments.
#
#   tests/faults/disk.sh BIN FOLDER [short]
#
# Needs the right to mount a tmpfs, and is skipped (77) without it. common.sh says the
# rest.
# shellcheck source=tests/faults/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

options+=(--reconstruct.iterations 60)
stages=(ingest sfm undistort reconstruct bootstrap export)

unmount_small() { while umount small 2>/dev/null; do :; done; }
mount_small() { unmount_small && mount -t tmpfs -o size=120m tmpfs small 2>/dev/null; }
trap 'kill_jobs; unmount_small' EXIT

# Root may write everywhere but there.
refuses_read_only_workspace() {
  mount_small || return 1
  cp -a reference small/w && mount -o remount,ro small
  run small/w "${known_poses[@]}"
  [ $? = 3 ] && "$program" status small/w >out.txt 2>&1
}
# survives_full_disk FREE_KB SAME STAGES OPTION...: runs twice with the disk full, the
# second time from what the first has left; then there is room again. "STAGE STAGE..."
# are done before and must stay. SAME compares at the end.
survives_full_disk() {
  local available code stage finished
  read -ra finished <<<"$3"
  mount_small || return 1
  fresh small/w "${finished[@]}"
  available=$(df -k --output=avail small | tail -n 1)
  fallocate -l "$((available - $1))K" small/fill
  for _ in 1 2; do
    run small/w "${@:4}"
    code=$?
    [ $code = 0 ] || [ $code = 1 ] || return 1
  done
  for stage in "${finished[@]}"; do [ -e "small/w/$stage/stage.json" ] || return 1; done
  rm small/fill
  run small/w "${@:4}" && "$2" small/w
}

mkdir -p small
if ! mount_small; then
  echo "skipped: full disks and a read-only workspace need mount"
  exit 77
fi
run_undisturbed reference "${known_poses[@]}"
run_undisturbed reference_poses --to sfm
report "read-only workspace" refuses_read_only_workspace
for fault in $(every_fifth_if_short {0..5}:{20,150,1500,4000}); do
  at=${fault%:*} free=${fault#*:} to="bootstrap"
  [ "${stages[at]}" != export ] || to="export"
  report "disk full in ${stages[at]} with $free kB left" survives_full_disk "$free" \
    same_scene "${stages[*]:0:at}" "${known_poses[@]}" --to $to
done
for free in $(every_fifth_if_short 100 600 1200 2400); do
  report "disk full with COLMAP and $free kB left" survives_full_disk "$free" \
    same_poses ingest --to sfm
done
verdict
