#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# One job of the workflow: brings one stage of one scene up to date, and then plans
# what the stages after it will need.
#
#   job.sh PROGRAM IMAGES WORKSPACE STAGE THREADS PLAN_THREADS ATTEMPT AGAIN [OPTION ...]
#
# What the program says goes to WORKSPACE/.workflow/STAGE.log. A failure leaves
# STAGE.failed beside it: the exit code, what was asked for, and the last words.
# Codes 2 to 5 are about the scene or the command and not about the machine, so a
# second attempt does not try again. A verdict (4) took long and holds for later runs
# of the workflow, too, until the photos, the options or the program change, or AGAIN
# is not 0.
set -uo pipefail

program=$1 images=$2 workspace=$3 stage=$4 threads=$5 plan_threads=$6 attempt=$7 again=$8
shift 8
state=$workspace/.workflow
failed=$state/$stage.failed
log=$state/$stage.log
mkdir -p -- "$state" && exec 2>"$log" || exit 1

# What a verdict is about: program, options, and names, sizes and times of photos.
asked() {
  {
    "$program" --version
    printf '%s\n' "$@"
    find -L "$images" -type f -printf '%P %s %T@\n' | LC_ALL=C sort
  } 2>&1 | sha256sum | cut -d' ' -f1
}

if [[ -f $failed ]]; then
  { read -r code && read -r about; } <"$failed"
  if [[ $code == [2-5] && $attempt -gt 1 ]] ||
    [[ $code == 4 && $again == 0 && $about == "$(asked "$@")" ]]; then
    sed 1,2d "$failed" >&2
    exit "$code"
  fi
  rm -f -- "$failed"
fi

# A job that was taken for lost may still work here: wait until it ends. The kernel
# lets the lock go when the process dies, the file server when the machine does.
if ! flock --nonblock "$workspace/.lock" true; then
  echo "$stage: waiting for another job that works in $workspace" >&2
  flock "$workspace/.lock" true
fi

run=(--from "$stage" --to "$stage" --threads "$threads")
code=0
"$program" run "$images" "$workspace" "${run[@]}" "$@" || code=$?
if ((code != 0)); then
  {
    echo "$code"
    asked "$@"
    # The last message; without one, the program was killed.
    # Names in it need not be UTF-8.
    grep -a '^freegs_pipeline: ' "$log" | tail -n 1 | LC_ALL=C cut -d' ' -f2-
  } >"$failed.new"
  mv -- "$failed.new" "$failed"
  exit "$code"
fi

# Without a plan the workflow asks for what it asks by default.
plan=$state/plan.json
if "$program" plan "$workspace" --images "$images" --threads "$plan_threads" "$@" \
  --json >"$plan.part" 2>/dev/null; then
  mv -- "$plan.part" "$plan"
else
  rm -f -- "$plan" "$plan.part"
fi
