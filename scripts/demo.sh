#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Makes a 3D scene, beginning with a clean checkout: installs packages, builds the
# program, draws sample photos if none are given, and runs the whole pipeline.
#
#   scripts/demo.sh [IMAGES [OPTION ...]]
#
# IMAGES is a folder of photos. Options are passed to `freegs_pipeline run`, for
# example --preset balanced or --within 5m; the preset is fast if they do not say
# otherwise. The result is in demo_workspace of the checkout, or in
# demo_workspace_NAME_NUMBER for a folder NAME of photos, where the number follows from
# its path. If the script is run again, it goes on from there. What the steps print is
# kept in demo_workspace.log.
set -euo pipefail
unset CDPATH  # It would lead cd to other folders.
if [[ ${1:-} == --help || ${1:-} == -h ]]; then
  sed -n '3,/^set /s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
  exit
fi
here=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build=${BUILD:-build}
photos=demo_photos
workspace=demo_workspace
log=$PWD/$workspace.log

images=""
if (($# > 0)) && [[ $1 != --* ]]; then
  images=$(cd "$here" && realpath -m -- "$1")
  [[ -e $images ]] || { echo "error: there is no $images" >&2; exit 3; }
  # Other photos in a folder of the same name have another workspace.
  workspace+=_${images##*/}_$(cksum <<<"$images" | cut -d ' ' -f 1)
  shift
fi

# Seconds that each step is guessed to take, on a machine with nothing installed.
# Of a film it is not known yet how many photos it gives.
num_photos=40
draw_seconds=$((48 / $(nproc)))
if [[ -n $images ]]; then
  draw_seconds=0
  # Folders that cannot be read and links that lead back are left out, as `run` does.
  [[ ! -d $images ]] ||
    num_photos=$({ find -L "$images" -type f 2>/dev/null || true; } | wc -l)
fi
install_seconds=75
build_seconds=$((300 / $(nproc)))
scene_seconds=$((3 * num_photos / $(nproc)))

minutes() {
  if (($1 < 60)); then
    echo "$1 s"
  else
    echo "$(($1 / 60)) min $(($1 % 60)) s"
  fi
}
# How far the step is, as "12 138", from what it says in the log: the last line of
# ninja that counts; or the packages of apt, each of which is unpacked and set up.
how_far() {
  local packages
  case $1 in
    building)
      tail -n 3 "$log" | sed -nE 's|^\[ *([0-9]+)/([0-9]+)\].*|\1 \2|p' | tail -n 1
      ;;
    installing*)
      packages=$(sed -nE 's/.* ([0-9]+) newly installed.*/\1/p' "$log")
      [[ -z $packages ]] ||
        echo "$(grep -cE '^(Unpacking|Setting up) ' "$log") $((2 * packages))"
      ;;
  esac
}
# The step that runs is a process group of its own, which ends with the script. In the
# group of the script it would ignore Ctrl-C, as all that a script starts with & does.
job=""
end_step() {
  [[ -n $job ]] || return 0
  kill -TERM -- "-$job" 2>/dev/null || true
  kill -CONT -- "-$job" 2>/dev/null || true  # If it was stopped.
  wait "$job" 2>/dev/null || true
  job=""
}
# Ends by the signal, so that whoever called the script knows.
end_by() {
  end_step
  trap - EXIT "$1"
  kill -s "$1" "$$"
}
trap end_step EXIT
for signal in HUP INT TERM; do
  # shellcheck disable=SC2064
  trap "end_by $signal" "$signal"
done
# step NAME SECONDS LATER COMMAND...: runs the command, which takes about SECONDS,
# and shows how long it and the LATER seconds of other steps will last. Its output
# goes to the log, and to the terminal when it fails.
step() {
  local name=$1 expected=$2 later=$3 start=$SECONDS shown=-30 passed left counted total
  shift 3
  set -m
  "$@" >>"$log" 2>&1 </dev/null &
  job=$!
  set +m
  while kill -0 "$job" 2>/dev/null; do
    # The terminal stops a step that asks something there, such as a password.
    if grep -qs '^State:.T' "/proc/$job/status"; then
      echo "the step waits for an answer, which nobody can give" >>"$log"
      kill -TERM -- "-$job" && kill -CONT -- "-$job"
    fi
    passed=$((SECONDS - start))
    left=$((expected > passed ? expected - passed : 5))
    if read -r counted total < <(how_far "$name") && ((counted > 8)); then
      left=$((passed * (total - counted) / counted))
    fi
    if [[ -t 2 && ${TERM:-dumb} != dumb ]]; then
      printf '\r\033[K%s, about %s left for the whole' "$name" "$(minutes $((left + later)))" >&2
    elif ((passed - shown >= 30)); then
      shown=$passed
      echo "$name, about $(minutes $((left + later))) left for the whole" >&2
    fi
    sleep 1
  done
  [[ ! -t 2 || ${TERM:-dumb} == dumb ]] || printf '\r\033[K' >&2
  local status=0
  wait "$job" || status=$?
  job=""
  if ((status != 0)); then
    tail -n 30 "$log" >&2
    echo "error: $name failed; all of it is in $log" >&2
    exit "$status"
  fi
  echo "$name: done in $(minutes $((SECONDS - start)))" >&2
}
build_program() {
  scripts/configure.sh "$build" -DFREEGS_BUILD_TESTS=ON
  cmake --build "$build" --parallel "$(nproc)" \
    --target freegs_pipeline freegs_make_scene
}

# The line that says how long it will take would hide sudo's question for a password.
if ((EUID != 0)) && command -v sudo >/dev/null && ! scripts/install_packages.sh --check; then
  # Where sudo asks for no password, `sudo -v` may still ask.
  sudo -n true 2>/dev/null || sudo -v || true
fi
: >"$log"
step "installing packages" "$install_seconds" \
  $((build_seconds + draw_seconds + scene_seconds)) scripts/install_packages.sh
step "building" "$build_seconds" $((draw_seconds + scene_seconds)) build_program

truth=""
if [[ -z $images ]]; then
  if [[ ! -f $photos/gt/cameras.json ]]; then
    # Under its name there is never half a scene.
    rm -rf -- "$photos.partial"
    step "drawing sample photos" "$draw_seconds" "$scene_seconds" \
      "$build/bin/freegs_make_scene" --out "$photos.partial" --views 40 \
      --width 640 --height 480 --seed 1
    mv -T -- "$photos.partial" "$photos"
  fi
  truth=$PWD/$photos
  images=$truth/images
fi

# Paths among the options hold where the script was called, and so does what the
# program proposes at the end.
seen_from_here() { realpath -sm --relative-base="$here" -- "$1"; }
program=$(seen_from_here "$build/bin/freegs_pipeline")
[[ $program == */* ]] || program=./$program
workspace=$(seen_from_here "$workspace")
cd "$here"
# From here on the program itself says how long the rest will take, and it heeds
# signals.
trap - EXIT HUP INT TERM
# A run with a goal chooses its preset itself.
preset=(--preset fast)
for option in "$@"; do
  [[ ! $option =~ ^--(within|at-least)(=|$) ]] || preset=()
done
"$program" run "$images" "$workspace" "${preset[@]}" "$@" >"$log.end"
if [[ -n $truth ]]; then
  echo "Compared with the truth, which drawn photos have:"
  "$program" eval "$workspace" --gt "$truth" --json "$workspace/eval.json" |
    tee -a "$log" | grep -E '^  (holdout PSNR|instance mIoU|text mIoU) '
fi
echo
echo "The whole took $(minutes "$SECONDS")."
program=$(printf %q "$program") workspace=$(printf %q "$workspace")
while IFS= read -r line; do
  [[ $line != "  freegs_pipeline "* ]] || line="  $program ${line#  freegs_pipeline }"
  printf '%s\n' "$line"
done <"$log.end"
rm -f -- "$log.end"
cat <<END
Or ask in words, with pictures and by clicking, in the browser:
  $program view $workspace --open
Look at the scene from anywhere:
  $program render $workspace --path orbit --video orbit.mp4
The scene for other programs, masks and boxes: $workspace/export
END
