#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Kills a run with SIGKILL at random moments, runs again after each, and checks
# that nothing is lost: stages that were done stay done, the run ends, and the
# final scene and its semantic field have the bytes of an undisturbed run from
# the same structure from motion.
#
#   tests/kill_resume.sh PROGRAM IMAGES FOLDER [KILLS_PER_STAGE] [OPTION ...]
#
# FOLDER is made and holds the two workspaces. WITHIN is how many seconds into a
# stage a kill comes at most (default: 20); take the length of the longest. Not
# part of the test suite: it takes as long as several runs.
set -euo pipefail

program=$1 images=$2 folder=$3 kills=${4:-7}
shift $(($# < 4 ? $# : 4))
within=${WITHIN:-20}
stages=(sfm reconstruct bootstrap)
workspace=$folder/killed
log=$folder/runs.log
mkdir -p "$folder"

# Finished stages and when they finished: what must survive a kill.
finished() {
  find "$workspace" -mindepth 2 -maxdepth 2 -name stage.json \
    -not -path '*.partial/*' -exec stat -c '%n %Y' {} + 2>/dev/null | sort
}

killed=0
for stage in "${stages[@]}"; do
  for ((k = 0; k < kills; ++k)); do
    "$program" run "$images" "$workspace" "$@" >>"$log" 2>&1 & pid=$!
    # Wait for the stage to begin; it may already be over.
    while kill -0 "$pid" 2>/dev/null && [ ! -e "$workspace/$stage.partial" ]; do
      sleep 0.02
    done
    # A random moment, in the first kills an early one.
    sleep "$(awk -v r=$RANDOM -v k="$k" -v within="$within" \
      'BEGIN { print r / 32768 * (k < 3 ? 0.4 * (k + 1) : within) }')"
    before=$(finished)
    if [ -e "$workspace/$stage.partial" ] && kill -9 "$pid" 2>/dev/null; then
      wait "$pid" 2>/dev/null || true
      killed=$((killed + 1))
      echo "killed during $stage ($killed)"
      lost=$(comm -23 <(echo "$before") <(finished))
      if [ -n "$lost" ]; then
        echo "LOST after a kill during $stage: $lost" >&2
        exit 1
      fi
    fi
    wait "$pid" 2>/dev/null || true
    # A stage that ended before the kill is done again from the start.
    if [ ! -e "$workspace/$stage.partial" ]; then
      rm -rf "${workspace:?}/$stage"
    fi
  done
done

if ((killed == 0)); then
  echo "no kill came while a stage was at work: take a smaller WITHIN, which is" \
    "$within seconds" >&2
  exit 1
fi
echo "killed $killed times; now to the end"
"$program" run "$images" "$workspace" "$@" >>"$log" 2>&1
reference=$folder/undisturbed
rm -rf "$reference"
mkdir -p "$reference"
for part in workspace.json config.ini ingest sfm undistort; do
  [ ! -e "$workspace/$part" ] || cp -a "$workspace/$part" "$reference/"
done
"$program" run "$images" "$reference" "$@" >>"$log" 2>&1
cmp "$workspace/reconstruct/point_cloud.ply" \
  "$reference/reconstruct/point_cloud.ply"
for file in idsf.bin instances.json instance_features.json; do
  [ ! -e "$reference/bootstrap/$file" ] ||
    cmp "$workspace/bootstrap/$file" "$reference/bootstrap/$file"
done
echo "same bytes after $killed kills"
