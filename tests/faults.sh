#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Tries on a small drawn scene what can go wrong around a run: full disks, too
# little memory, signals, a clock that is set back, a COLMAP that hangs, lies,
# forks or is killed, two runs at once, and files that somebody deletes, edits
# or swaps. Prints one line per fault, and fails when something is lost or when
# a run cannot be taken up again.
#
#   tests/faults.sh BIN FOLDER [short]
#
# BIN is the folder of the built programs. FOLDER is made anew. Needs COLMAP;
# full disks need the right to mount a tmpfs, a clock needs libfaketime, and they
# are left out without it. Takes some five minutes. The short form takes two: it
# tries every fifth output, amount of memory, signal to COLMAP, and moment at which
# the disk is full.
set -uo pipefail
unset CDPATH  # It would lead cd to other folders.

program=$(realpath "$1")/freegs_pipeline
maker=$(realpath "$1")/freegs_make_scene
mkdir -p "$2"
cd "$2" || exit 1
folder=$PWD
form=${3:-whole}
failures=0
# Nothing that was begun lives on, and no disk stays mounted.
clean_up() {
  local left
  left=$(jobs -pr)
  # shellcheck disable=SC2086
  [ -z "$left" ] || kill -KILL $left
  wait
  umount small 2>/dev/null
}
trap clean_up EXIT
trap 'exit 130' INT TERM
# What an earlier test has left that was killed.
while umount small 2>/dev/null; do :; done
common=(--reconstruct.budget 2000 --threads 2
  --general.checkpoint_interval 1 --bootstrap.mode geometry)
options=("${common[@]}" --reconstruct.iterations 150)
poses=(--sfm.import scene/gt/transforms.json --sfm.random_points 10000)

run() { "$program" run scene/images "$@" >out.txt 2>&1; }

# report NAME TRUE|FALSE-COMMAND...: one line, and the log of what went wrong.
report() {
  local name=$1
  shift
  if "$@"; then
    echo "held  $name"
  else
    echo "LOST  $name"
    tail -n 5 out.txt | sed 's/^/      /'
    failures=$((failures + 1))
  fi
}

# Starts a run and waits until a file appears: begin WORKSPACE PATTERN OPTION ...
begin() {
  local pattern=$2 workspace=$1
  shift 2
  : >out.txt
  "$program" run scene/images "$workspace" "$@" >out.txt 2>&1 &
  pid=$!
  until compgen -G "$pattern" >/dev/null || ! kill -0 "$pid" 2>/dev/null; do sleep 0.05; done
}

# Goes on in w from a checkpoint, and waits until it trains: go_on OPTION ...
go_on() {
  begin w w/reconstruct.partial "$@"
  until grep -q "resuming at iteration" out.txt || ! kill -0 "$pid" 2>/dev/null; do
    sleep 0.05
  done
}

# end SIGNAL CODE: sends the signal and expects the exit code.
end() {
  kill "-$1" "$pid"
  wait "$pid" 2>/dev/null
  [ $? = "$2" ]
}

# Whether a workspace has the bytes of the undisturbed run $reference.
same_scene() {
  cmp -s "$1/reconstruct/point_cloud.ply" $reference/reconstruct/point_cloud.ply &&
    cmp -s "$1/bootstrap/idsf.bin" $reference/bootstrap/idsf.bin
}
runs_on() { run "$@" && same_scene "$1"; }

# Prints the values, or every fifth one in the short form: some VALUE ...
some() {
  local step=1 at
  [ "$form" = short ] && step=5
  for ((at = 1; at <= $#; at += step)); do echo "${!at}"; done
}

# A new workspace in which the first stages are done: fresh NAME STAGE ...
fresh() {
  local workspace=$1 stage
  shift
  rm -rf "$workspace" && mkdir "$workspace"
  cp -a ref/workspace.json "$workspace/"
  for stage in "$@"; do cp -a "ref/$stage" "$workspace/"; done
}

# colmap NAME: a stand-in for COLMAP whose script comes from standard input.
colmap() {
  { echo '#!/bin/bash'; cat; echo 'exec colmap "$@"'; } >"$1"
  chmod +x "$1"
}

rm -rf scene ref slow w small
"$maker" --out scene --views 12 --width 240 --height 180 >/dev/null 2>&1 || exit 1
run ref "${poses[@]}" "${options[@]}" || { cat out.txt; exit 1; }

# What disturbs a live run. It trains long enough to be met while it trains, and
# has a checkpoint after a second. same_scene needs no stage after bootstrap.
reference=slow
all=("${poses[@]}" "${common[@]}" --reconstruct.iterations 800 --to bootstrap)
checkpoint='w/reconstruct.partial/checkpoints/*.ckpt'
fresh slow ingest sfm undistort
run slow "${all[@]}" || { cat out.txt; exit 1; }
# One run meets all signals, one after the other, and goes on to the end after them.
fresh w ingest sfm undistort
start=(begin w "$checkpoint")
for signal in INT TERM HUP; do
  if [ $signal = HUP ] && [ -n "$(trap -p HUP)" ]; then
    echo "left out: SIGHUP, which nohup ignores"
    continue
  fi
  "${start[@]}" "${all[@]}"
  start=(go_on)
  report "SIG$signal while training" end "$signal" 130
done
go_on "${all[@]}"
twice() { kill -INT "$pid"; end INT 130; }
report "SIGINT twice" twice
go_on "${all[@]}"
left_lock() { end KILL 137 && runs_on w "${all[@]}"; }
report "a lock left by kill -9; the bytes after all these signals" left_lock
fresh w ingest sfm undistort
"$program" run scene/images w "${all[@]}" 2>&1 | head -n 4 >out.txt
report "SIGPIPE: the reader of the log is gone" same_scene w

# Two runs at once.
fresh w ingest sfm undistort
begin w w/reconstruct.partial "${all[@]}"
second() {
  "$program" run scene/images w "${all[@]}" >out.txt 2>&1
  [ $? = 3 ] && grep -q "another freegs_pipeline" out.txt && wait "$pid" &&
    same_scene w
}
report "two runs on one workspace" second

# Checkpoints.
fresh w ingest sfm undistort
begin w "$checkpoint" "${all[@]}"
damaged() {
  end INT 130 || return 1
  local file
  for file in $checkpoint; do
    printf damaged | dd of="$file" bs=1 seek=2000 conv=notrunc 2>/dev/null || return 1
  done
  runs_on w "${all[@]}"
}
report "every checkpoint damaged" damaged

# The clock.
fake_time=$(ls /usr/lib/*/faketime/libfaketimeMT.so.1 2>/dev/null | head -n 1)
if [ -n "$fake_time" ]; then
  fresh w ingest sfm undistort
  echo +0 >clock
  set_back() {
    (export LD_PRELOAD=$fake_time FAKETIME_TIMESTAMP_FILE=$folder/clock \
      FAKETIME_NO_CACHE=1 FAKETIME_DONT_FAKE_MONOTONIC=1 NO_FAKE_STAT=1
      exec "$program" run scene/images w "${all[@]}" >out.txt 2>&1) &
    pid=$!
    until [ -e w/reconstruct.partial ] || ! kill -0 "$pid" 2>/dev/null; do sleep 0.05; done
    echo -30d >clock
    wait "$pid" && same_scene w && run w "${all[@]}" &&
      [ "$(grep -c 'up to date' out.txt)" = 5 ]
  }
  report "clock set back by a month on a live run" set_back
else
  echo "left out: a clock that is set back needs libfaketime"
fi

# From here on runs are short.
reference=ref
all=("${poses[@]}" "${options[@]}")
to_bootstrap=("${all[@]}" --to bootstrap)

# Too little memory. Below some limit not even the libraries can be loaded. GDAL,
# which OpenCV calls when it reads the first photo, and Ceres, whose timer throws
# while it is destroyed, then end the process themselves (134 or 139), and say so.
few_bytes() {
  local code
  { (ulimit -c 0 -v "$1" && run w "${@:2}"); } 2>/dev/null
  code=$?
  case $code in
    0) ;;
    1) grep -q "memory" out.txt ;;
    134 | 139) grep -qE "GDAL|std::bad_alloc" out.txt ;;
    *) false ;;
  esac
}
limits=0
for limit in $(some {320000..390000..6000}); do
  { (ulimit -c 0 -v "$limit" && "$program" --version); } >/dev/null 2>&1 || continue
  limits=$((limits + 1))
  rm -rf w
  limited() { few_bytes "$limit" "${to_bootstrap[@]}" && runs_on w "${to_bootstrap[@]}"; }
  report "ulimit -v $limit" limited
done
[ $limits -gt 0 ] || report "none of the limits lets the libraries be loaded" false

# Threads that cannot be made. Root has no limit, so another user runs it.
if [ "$(id -u)" = 0 ] && setpriv --reuid 61234 --clear-groups \
  test -x "$program" -a -r scene/images; then
  for threads in $(some 1 2 3); do
    rm -rf w && mkdir -m 777 w
    few_threads() {
      setpriv --reuid 61234 --clear-groups bash -c "ulimit -u $threads; exec \"\$@\"" \
        bash "$program" run scene/images w "${all[@]}" >out.txt 2>&1 && same_scene w
    }
    report "ulimit -u $threads" few_threads
  done
else
  echo "left out: a limit of threads needs root, and folders that all may read"
fi

# The dates of files say nothing.
for date in 1990-01-01 2090-01-01; do
  rm -rf w && cp -a ref w && find w -exec touch -hd "$date" {} +
  dated() { run w "${all[@]}" && [ "$(grep -c 'up to date' out.txt)" = 6 ]; }
  report "all files dated $date" dated
done

# Outputs: each is made again, or the message says how. Without stage.json a
# folder counts as somebody else's.
for file in $(some ref/*/*); do
  file=${file#ref/}
  rm -rf w && cp -a ref w && rm -r "w/$file"
  again() {
    local code
    run w "${all[@]}"
    code=$?
    case $file in
      */stage.json) [ $code = 3 ] && grep -q "delete it" out.txt ;;
      */logs | */checkpoints | */features | sfm/database.db)
        [ $code = 0 ] && same_scene w && ! grep -q "deleted" out.txt ;;
      *) [ $code = 0 ] && same_scene w &&
        { [ -e "w/$file" ] || grep -q "deleted ('freegs_pipeline stage" out.txt; } ;;
    esac
  }
  report "$file deleted" again
done
for file in ingest/photos/frame_0002.jpg undistort/images/frame_0003.jpg \
  sfm/sparse/0/points3D.bin; do
  rm -rf w && cp -a ref w && rm "w/$file"
  report "$file deleted" runs_on w "${to_bootstrap[@]}"
done
# One byte is another: what follows is made anew.
rm -rf w && cp -a ref w
ply=w/reconstruct/point_cloud.ply
printf '\001' | dd of=$ply bs=1 seek=$(($(stat -c %s $ply) - 1)) conv=notrunc 2>/dev/null
edited() { run w "${to_bootstrap[@]}" &&
  grep -q "bootstrap: input reconstruct/point_cloud.ply changed" out.txt; }
report "point_cloud.ply edited: what follows is made anew" edited
rm -rf w other && cp -a ref w && mkdir other &&
  cp -a ref/{workspace.json,ingest,sfm,undistort} other/
run other "${to_bootstrap[@]}" --reconstruct.budget 500
cp other/bootstrap/idsf.bin w/bootstrap/idsf.bin
swapped() {
  "$program" render w --what instances --out r >out.txt 2>&1
  [ $? = 3 ] && grep -q "stage bootstrap" out.txt
}
report "idsf.bin of another scene: told how to make it again" swapped
rm -rf w && cp -a ref w && truncate -s 3000 w/reconstruct/point_cloud.ply
told() { ! run w "${to_bootstrap[@]}" && grep -q "stage reconstruct" out.txt &&
  "$program" stage reconstruct w >out.txt 2>&1 && runs_on w "${to_bootstrap[@]}"; }
report "point_cloud.ply cut short: told how to make it again" told

# COLMAP. Its own results are compared with those of an undisturbed run.
sfm=("${options[@]}" --to sfm)
run plain "${sfm[@]}" || { cat out.txt; exit 1; }
same_poses() { cmp -s "${1:-w}/sfm/sparse/0/images.bin" plain/sfm/sparse/0/images.bin; }
extracted() { stat -c %Y w/sfm*/logs/feature_extractor.log; }
for pair in $(some {mapper,feature_extractor,matches_importer}:{KILL,SEGV}); do
  command=${pair%:*}
  signal=${pair#*:}
  colmap killed <<<"[ \$1 = $command ] && [ \"\$2\" != --help ] &&
    rm ${folder@Q}/once 2>/dev/null && kill -$signal \$\$"
  rm -rf w && touch once
  killed() {
    run w "${sfm[@]}" --sfm.colmap "$folder/killed"
    [ $? = 1 ] || return 1
    local before
    before=$(extracted)
    run w "${sfm[@]}" --sfm.colmap "$folder/killed" && same_poses &&
      { [ $command = feature_extractor ] || [ "$before" = "$(extracted)" ]; }
  }
  report "colmap $command ended by SIG$signal" killed
done
for limit in $(some {400000..520000..40000}); do
  rm -rf w
  limited() { few_bytes "$limit" "${sfm[@]}" && run w "${sfm[@]}" && same_poses; }
  report "ulimit -v $limit with COLMAP" limited
done
colmap hangs <<<'[ $1 = mapper ] && [ "$2" != --help ] && sleep 1000'
rm -rf w
begin w w/sfm.partial/logs/mapper.log "${sfm[@]}" --sfm.colmap "$folder/hangs"
sleep 1
report "colmap hangs: Ctrl-C" eval 'end INT 130 && run w "${sfm[@]}" && same_poses'
colmap forks <<<"[ \$1 = mapper ] && [ \"\$2\" != --help ] &&
  { sleep 1000 & echo \$! >${folder@Q}/grandchild; wait; }"
for signal in KILL INT; do
  rm -rf w grandchild
  begin w grandchild "${sfm[@]}" --sfm.colmap "$folder/forks"
  sleep 0.3
  kill "-$signal" "$pid"
  kill "-$signal" "$pid" 2>/dev/null
  wait "$pid" 2>/dev/null
  sleep 0.5
  gone() { [ -s grandchild ] && ! grep -qs sleep "/proc/$(cat grandchild)/cmdline"; }
  report "colmap forks: nothing lives on after SIG$signal twice" gone
done
colmap lies <<<'[ $1 = mapper ] && [ "$2" != --help ] && {
  while [ $# -gt 0 ]; do [ "$1" = --output_path ] && out=$2; shift; done
  mkdir "$out/0" && for f in cameras images points3D; do
    head -c 100 /dev/urandom >"$out/0/$f.bin"; done; exit 0; }'
rm -rf w
lied() { ! run w "${sfm[@]}" --sfm.colmap "$folder/lies" &&
  [ ! -e w/sfm ] && run w "${sfm[@]}" && same_poses; }
report "colmap lies: its model is noise" lied

# A workspace that cannot be written; root may write everywhere but there.
mkdir -p small
if mount -t tmpfs -o size=64m tmpfs small 2>/dev/null; then
  cp -a ref small/w && mount -o remount,ro small
  read_only() { run small/w "${all[@]}"
    [ $? = 3 ] && "$program" status small/w >out.txt 2>&1; }
  report "read-only workspace" read_only
  umount small
  # The disk is full at ever later moments; then there is room again.
  # Twice each, the second time after the run was taken up.
  for pair in $(some {ingest,sfm,undistort,reconstruct,bootstrap,export}:{20,150,1500,4000}); do
    stage=${pair%:*}
    free=${pair#*:}
    before=()
    upto=("${to_bootstrap[@]}")
    [ $stage = export ] && upto=("${all[@]}")
    for done in ingest sfm undistort reconstruct bootstrap export; do
      [ "$done" = "$stage" ] && break
      before+=("$done")
    done
    mount -t tmpfs -o size=120m tmpfs small
    fresh small/w "${before[@]}"
    available=$(df -k --output=avail small | tail -n 1)
    dd if=/dev/zero of=small/fill bs=1k count=$((available - free)) 2>/dev/null
    full() {
      local code
      for _ in 1 2; do
        run small/w "${upto[@]}"
        code=$?
        [ $code = 0 ] || [ $code = 1 ] || return 1
      done
      for done in "${before[@]}"; do [ -e "small/w/$done/stage.json" ] || return 1; done
      rm small/fill
      runs_on small/w "${upto[@]}"
    }
    report "disk full in $stage with $free kB left" full
    umount small
  done
  for free in $(some 100 600 1200 2400); do
    mount -t tmpfs -o size=120m tmpfs small
    fresh small/w ingest
    available=$(df -k --output=avail small | tail -n 1)
    dd if=/dev/zero of=small/fill bs=1k count=$((available - free)) 2>/dev/null
    full() {
      local code
      for _ in 1 2; do
        run small/w "${sfm[@]}"
        code=$?
        [ $code = 0 ] || [ $code = 1 ] || return 1
      done
      rm small/fill
      run small/w "${sfm[@]}" && same_poses small/w
    }
    report "disk full with COLMAP and $free kB left" full
    umount small
  done
else
  echo "left out: full disks and a read-only workspace need mount"
fi
[ $failures = 0 ] || { echo "$failures faults cost something"; exit 1; }
echo "nothing is lost"
