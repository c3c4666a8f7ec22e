#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The workflow of scripts/workflow with six scenes, three at once: a job is killed,
# one scene fails honestly, a machine is lost. Ends with the bytes of undisturbed runs
# and a page of all six. The profiles of the clusters are tried without running
# anything.
#
#   tests/workflow.sh BIN FOLDER
#
# FOLDER is made anew. Exit code 77: snakemake is missing, nothing was tried.
set -euo pipefail
unset CDPATH  # It would lead cd to other folders.

if ! command -v snakemake >/dev/null; then
  echo "workflow.sh: skipped, snakemake is missing;" \
    "scripts/install_packages.sh --workflow installs it"
  exit 77
fi
bin=$(realpath "$1")
workflow=$(realpath "$(dirname "${BASH_SOURCE[0]}")/../scripts/workflow")
rm -rf -- "$2"
mkdir -p -- "$2"
cd -- "$2"
folder=$PWD
work=$folder/workspaces
program=$bin/freegs_pipeline
options=(--preset fast --reconstruct.iterations 400 --general.checkpoint_interval 1)

fail() {
  echo "workflow.sh: $*" >&2
  tail -n 30 "$folder/runs.log" >&2
  exit 1
}
# Ends what still runs: snakemake and its jobs are one process group.
group=""
clean_up() {
  [[ -z $group ]] || kill -9 -- "-$group" 2>/dev/null || true
}
trap clean_up EXIT
wait_until() { # SECONDS WHAT COMMAND ...
  local seconds=$1 what=$2
  shift 2
  for ((i = 0; i < 20 * seconds; ++i)); do
    ! "$@" || return 0
    kill -0 "$group" 2>/dev/null || break
    sleep 0.05
  done
  fail "waited in vain until $what"
}
count() { find "$work" -path "$1" 2>/dev/null | wc -l; }
at_least() { (($(count "$2") >= $1)); }
at_work() { # How many scenes have a job now.
  local lock busy=0
  for lock in "$work"/*/.lock; do
    [[ ! -e $lock ]] || flock --nonblock "$lock" true || busy=$((busy + 1))
  done
  (("$busy" >= $1))
}
run_workflow() { # [TARGET] OPTION ...
  snakemake "$@" --snakefile "$workflow/Snakefile" --nocolor \
    --configfile "$folder/scenes.yaml" >>"$folder/runs.log" 2>&1
}

# Two drawn rooms, photographed for five scenes, and one where all is plain.
draw=(--views 12 --test_views 2 --width 240 --height 180)
for seed in 1 2; do
  "$bin/freegs_make_scene" --out "drawn$seed" --seed "$seed" "${draw[@]}" >/dev/null 2>&1
done
"$bin/freegs_make_scene" --out drawn_plain --texture none "${draw[@]}" >/dev/null 2>&1
mkdir photos
for scene in one two three; do ln -s ../drawn1/images "photos/$scene"; done
for scene in four five; do ln -s ../drawn2/images "photos/$scene"; done
ln -s ../drawn_plain/images photos/plain
cat >scenes.yaml <<SCENES
program: $program
workspaces: workspaces
photos: photos
options: ${options[*]}
threads: {ingest: 1, sfm: 1, undistort: 1, reconstruct: 1, bootstrap: 1, export: 1}
scenes:
  five: {images: photos/five, truth: drawn2}
SCENES

echo "profiles"
for profile in local slurm kubernetes; do
  run_workflow -n --profile "$workflow/profiles/$profile" || fail "profile $profile"
  [[ $(grep -c '^total  *38 ' runs.log) -gt 0 ]] || fail "$profile plans other jobs"
  : >runs.log
done
[[ ! -e $work ]] || fail "a dry run wrote something"
mkdir kubernetes
printf '#!/bin/sh\ncat\n' >kubernetes/kubectl
chmod +x kubernetes/kubectl
PATH=$folder/kubernetes:$PATH FREEGS_IMAGE=image FREEGS_CLAIM=claim \
  "$workflow/profiles/kubernetes/submit.sh" 2 1000 10 job.sh >kubernetes/job.yaml ||
  fail "submit.sh of Kubernetes"
# Of the pod, so that the time without a machine does not count.
grep -q '^      activeDeadlineSeconds: 600$' kubernetes/job.yaml ||
  fail "the time limit of Kubernetes is not the pod's"

local_run=(--profile "$workflow/profiles/local" --cores 3 --resources mem_mb=8000)
begin() {
  setsid bash -c 'exec snakemake "$@"' _ --snakefile "$workflow/Snakefile" \
    --configfile "$folder/scenes.yaml" --nocolor "${local_run[@]}" \
    >>"$folder/runs.log" 2>&1 &
  group=$!
}

echo "six scenes, three at once, one job killed"
begin
wait_until 120 "three scenes are at work" at_work 3
wait_until 300 "a scene is trained" at_least 1 '*/reconstruct.partial/checkpoints/*'
partial=$(dirname "$(find "$work" -path '*/reconstruct.partial/checkpoints/*' -print -quit)")
killed=$(basename "$(dirname "$(dirname "$partial")")")
# shellcheck disable=SC2001  # Every special character gets a backslash.
pattern=$(sed 's/[][\.*^$+?(){}|]/\\&/g' <<<"$program")
pid=$(pgrep -f "^$pattern run .*/workspaces/$killed --from reconstruct" |
  head -n 1) || true
[[ -n $pid ]] || fail "the job of $killed is not found"
kill -9 "$pid" || fail "the job of $killed cannot be killed"
echo "  killed the training of $killed"
retried() { grep -q 'Trying to restart job' runs.log; }
wait_until 60 "the killed job is tried again" retried

echo "a machine is lost"
wait_until 300 "two scenes are trained" at_least 2 '*/reconstruct/stage.json'
kill -9 -- "-$group"
wait "$group" 2>/dev/null || true
group=""
lost=$(basename "$(dirname "$(dirname "$(find "$work" -path '*/reconstruct/stage.json' -print -quit)")")")
rm -rf .snakemake "$work"/*/*.partial "${work:?}/$lost/sfm"
echo "  gone: what was unfinished, and the camera poses of $lost"

echo "the same command again"
code=0
begin
wait "$group" || code=$?
group=""
((code == 1)) || fail "ends with $code; one scene should have failed"
for seed in 1 2; do
  "$program" run "drawn$seed/images" "alone$seed" "${options[@]}" >>runs.log 2>&1
done
for scene in one two three four five; do
  alone=alone1
  [[ $scene != four && $scene != five ]] || alone=alone2
  for file in sfm/sparse/0/images.bin reconstruct/point_cloud.ply bootstrap/idsf.bin \
    bootstrap/instances.json export/scene.ply; do
    cmp "$work/$scene/$file" "$alone/$file" || fail "$scene ends with other bytes"
  done
  grep -q '"memory_bytes"' "$work/$scene/.workflow/plan.json" || fail "$scene has no plan"
done

echo "the scene that failed, and the page"
failed=$work/plain/.workflow/sfm.failed
[[ $(head -n 1 "$failed") == 4 ]] || fail "the plain scene did not fail with code 4"
[[ $(find "$work" -name '*.failed' | wc -l) == 1 ]] || fail "other jobs failed, too"
page=$work/index.html
[[ $(grep -c '^<tr><td>' "$page") == 6 ]] || fail "the page does not list six scenes"
grep -q '5 complete, 1 failed, 0 unfinished' "$page" || fail "the page counts wrongly"
grep -q 'failed in sfm (exit code 4).*too little texture' "$page" ||
  fail "the page does not say why the plain scene failed"
[[ $(grep -o 'href="[^"]*"' "$page" | cut -d'"' -f2 |
  while read -r link; do ls "$work/$link"; done | wc -l) == 5 ]] || fail "broken links"

echo "once more: nothing is done again"
stamps() { find "$work" -name stage.json -printf '%p %T@\n' | sort; }
before=$(stamps)
code=0
run_workflow "${local_run[@]}" || code=$?
((code == 1)) || fail "a verdict is forgotten: exit code $code"
[[ $before == "$(stamps)" ]] || fail "what was finished was done again"

echo "photos come, options change: what they concern is done again"
mkdir photos/late
cp drawn1/images/* photos/late/
rm photos/late/frame_0012.jpg
again() {
  run_workflow "$work/late/.workflow/sfm" "${local_run[@]}" || fail "a late scene fails"
}
again
# While another job works there, the next one waits. The other one ends when it does, or
# after a minute.
cp drawn1/images/frame_0012.jpg photos/late/
flock "$work/late/.lock" bash -c 'for ((i = 0; i < 600; ++i)); do
  ! grep -qrs "waiting for another job" "$@" || exit
  sleep 0.1
done' _ runs.log "$work/late/.workflow" &
again
cmp "$work/late/sfm/sparse/0/images.bin" alone1/sfm/sparse/0/images.bin ||
  fail "a photo that came late was not noticed"
grep -q 'waiting for another job' runs.log "$work"/late/.workflow/*.log ||
  fail "a job did not wait for another"
sed -i 's/^options:.*/& --sfm.max_features 900/' scenes.yaml
again
grep -q '"sfm.max_features": "900"' "$work/late/sfm/stage.json" ||
  fail "a changed option was not noticed"
echo "workflow.sh: all is well"
