#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Says of a Job of Kubernetes what Snakemake wants to know: running, success or
# failed.
#
#   status.sh job.batch/NAME
set -uo pipefail

# A Job that somebody deleted is failed. When the cluster does not answer, nothing
# is known, and Snakemake asks again.
if ! found=$(kubectl get "$1" --ignore-not-found \
  -o jsonpath='{.kind} succeeded={.status.succeeded} failed={.status.failed}'); then
  echo running
elif [[ $found == *succeeded=1* ]]; then
  echo success
elif [[ -z $found || $found != *failed= ]]; then
  echo failed
else
  echo running
fi
