#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Says of a job of Slurm what Snakemake wants to know: running, success or failed.
#
#   status.sh JOB
set -uo pipefail

# With --parsable a job of a federation is named ID;CLUSTER.
job=${1%%;*}
state=$(sacct -j "$job" -X -n -P -o State 2>/dev/null | head -n 1)
if [[ -z $state ]]; then
  # No accounting. What is said of a job that Slurm does not know any more is that
  # its id is invalid; then another attempt finds out what is done.
  answer=$(scontrol -o show job "$job" 2>&1)
  state=$(sed -n 's/.*JobState=\([A-Z_]*\).*/\1/p' <<<"$answer")
  [[ $answer != *"Invalid job id"* ]] || state=UNKNOWN_JOB
fi
case $state in
  COMPLETED) echo success ;;
  # No answer at all: the controller is busy or away.
  "" | PENDING | CONFIGURING | RUNNING | COMPLETING | SUSPENDED | STOPPED) echo running ;;
  REQUEUE* | RESIZING | SIGNALING | STAGE_OUT | RESV_DEL_HOLD | SPECIAL_EXIT) echo running ;;
  *) echo failed ;;
esac
