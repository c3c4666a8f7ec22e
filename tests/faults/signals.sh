#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# What disturbs a run that trains: signals, a reader of the log that is gone, a second
# run, damaged checkpoints, a clock that is set back.
#
#   tests/faults/signals.sh BIN FOLDER [short]
#
# The clock needs libfaketime and is left out without it. common.sh says the rest.
# shellcheck disable=SC2034  # common.sh reads it.
num_threads=2
# shellcheck source=tests/faults/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

# Long enough to be met five times while it trains. same_scene needs no stage after
# bootstrap.
options+=("${known_poses[@]}" --reconstruct.iterations 500
  --general.checkpoint_interval 0.2 --to bootstrap)
before_training=(ingest sfm undistort)
checkpoints='w/reconstruct.partial/checkpoints/*.ckpt'

# Goes on in w from a checkpoint, and waits until it trains.
go_on() {
  begin w/reconstruct.partial
  until grep -q "resuming at iteration" out.txt || ! kill -0 "$pid" 2>/dev/null; do
    sleep 0.05
  done
}
frees_lock_of_killed_run() {
  expect_exit_after_signals 137 KILL && runs_to_same_scene w
}
survives_loss_of_reader() {
  fresh w "${before_training[@]}"
  "$program" run scene/images w "${options[@]}" 2>&1 | head -n 4 >out.txt
  same_scene w
}
refuses_second_run() {
  fresh w "${before_training[@]}"
  begin w/reconstruct.partial
  run w
  [ $? = 3 ] && grep -q "another freegs_pipeline" out.txt && wait "$pid" && same_scene w
}
survives_damaged_checkpoints() {
  local file
  fresh w "${before_training[@]}"
  begin "$checkpoints"
  expect_exit_after_signals 130 INT || return 1
  for file in $checkpoints; do
    printf damaged | dd of="$file" bs=1 seek=2000 conv=notrunc 2>/dev/null || return 1
  done
  runs_to_same_scene w
}
# survives_clock_set_back LIBRARY: by a month.
survives_clock_set_back() {
  fresh w "${before_training[@]}"
  echo +0 >clock
  LD_PRELOAD=$1 FAKETIME_TIMESTAMP_FILE=$PWD/clock FAKETIME_NO_CACHE=1 \
    FAKETIME_DONT_FAKE_MONOTONIC=1 NO_FAKE_STAT=1 begin w/reconstruct.partial
  echo -30d >clock
  wait "$pid" && runs_to_same_scene w && [ "$(grep -c 'up to date' out.txt)" = 5 ]
}

run_undisturbed reference
# One run meets all signals, one after the other, and goes on to the end after them.
fresh w "${before_training[@]}"
begin "$checkpoints"
report "SIGINT while training" expect_exit_after_signals 130 INT
go_on
report "SIGTERM while training" expect_exit_after_signals 130 TERM
if [ -z "$(trap -p HUP)" ]; then
  go_on
  report "SIGHUP while training" expect_exit_after_signals 130 HUP
else
  echo "left out: SIGHUP, which nohup ignores"
fi
go_on
report "SIGINT twice" expect_exit_after_signals 130 INT INT
go_on
report "a lock left by kill -9; the bytes after all these signals" frees_lock_of_killed_run
report "SIGPIPE: the reader of the log is gone" survives_loss_of_reader
report "two runs on one workspace" refuses_second_run
report "every checkpoint damaged" survives_damaged_checkpoints
fake_time=$(compgen -G '/usr/lib/*/faketime/libfaketimeMT.so.1' | head -n 1)
if [ -n "$fake_time" ]; then
  report "clock set back by a month on a live run" survives_clock_set_back "$fake_time"
else
  echo "left out: a clock that is set back needs libfaketime"
fi
verdict
