#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Makes a Job of Kubernetes from a job script of Snakemake, and prints its name.
#
#   submit.sh THREADS MEM_MB MINUTES SCRIPT
#
# The environment says
#   FREEGS_IMAGE   image with freegs_pipeline, COLMAP, snakemake and bash
#   FREEGS_CLAIM   claim of the volume that holds photos, workspaces, the program's
#                  workflow and the folder in which snakemake was started
#   FREEGS_MOUNT   where the volume is mounted, here and in the jobs (default: /data)
# Jobs run as the user who submits, so that all files are one user's.
set -euo pipefail

threads=$1 memory=$2 minutes=$3 script=$4
image=${FREEGS_IMAGE:?name the image in FREEGS_IMAGE}
claim=${FREEGS_CLAIM:?name the volume claim in FREEGS_CLAIM}
mount=${FREEGS_MOUNT:-/data}
kubectl create -f - -o name <<JOB
apiVersion: batch/v1
kind: Job
metadata:
  generateName: freegs-
spec:
  backoffLimit: 0
  ttlSecondsAfterFinished: 86400
  template:
    spec:
      restartPolicy: Never
      # Here and not in the Job, where it would count the wait for cores, too.
      activeDeadlineSeconds: $((60 * minutes))
      securityContext: {runAsUser: $(id -u), runAsGroup: $(id -g)}
      containers:
        - name: stage
          image: "$image"
          command: [sh, "$script"]
          env:
            - {name: HOME, value: /tmp}
          resources:
            requests: {cpu: "$threads", memory: ${memory}Mi}
            limits: {memory: ${memory}Mi}
          volumeMounts:
            - {name: shared, mountPath: "$mount"}
      volumes:
        - name: shared
          persistentVolumeClaim: {claimName: "$claim"}
JOB
